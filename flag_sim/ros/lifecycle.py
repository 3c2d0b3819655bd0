# Copyright 2026 The flag_sim Authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The lifecycle of a node, from its start to its end, the same for all of them."""
from collections.abc import Sequence
import contextlib
import ctypes
import os
import signal
import socket
import sys
import threading

from flag_sim.declarations.usage import asks_for_help, usage
from flag_sim.parameters.file_targets import given_files, is_meant, keys_in
from flag_sim.protocol.notify import NotifySender
from flag_sim.ros.dds_profile import set_dds_profile
from flag_sim.ros.parameter_node import BadParameter, ParameterNode
from flag_sim.ros.spinning import spin_guarded
import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args


M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of glibc's malloc.h
LARGEST_KEPT = 32 << 20  # the most that glibc takes [bytes]: an rgb8 image of 3840 x 2160 fits

NOTIFY_EVERY = 0.5  # how often the parent process is told how many frames were served [s]

# Kept for as long as the process lives: Python closes a socket without references.
_signal_sockets = socket.socketpair()


def keep_memory() -> None:
    """
    Let malloc keep the memory that a frame leaves; the next frame asks for as much again.

    glibc gives blocks of an image's size back to the system at once, and every page of the next
    one is fetched and cleared anew: at 640 x 480 that took half of the recorder's time. Other C
    libraries have no such call and are left as they are.
    """
    with contextlib.suppress(AttributeError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(M_MMAP_THRESHOLD, LARGEST_KEPT)
        mallopt(M_TRIM_THRESHOLD, 2 * LARGEST_KEPT)


def run(node_class: type[ParameterNode], args: Sequence[str] | None = None) -> int:
    """
    Run a node until it ends or is told to; return the exit status.

    The node has `ended`, a future that gets its exit status once it has ended by itself, and
    `close`, called however the node ends; where it returns True, something could not be finished,
    and the status is 1. SIGINT and SIGTERM else end it with status 0. The parent process
    is told, if it asks for that (see protocol.notify), when the node is ready for frames, its
    figures, and that it ends.
    """
    arguments = sys.argv if args is None else args
    if asks_for_help(arguments[1:]):
        try:
            print(usage(node_class), flush=True)
        except BrokenPipeError:  # as by `| head`; Python would flush once more at its end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    keep_memory()
    set_dds_profile()
    stop = _future_of_signals()
    try:
        # rclpy's own handlers would shut it down at once, before the node could close.
        context = rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        # What rclpy says of arguments and files that it cannot read.
        print(f'cannot start: {str(error).splitlines()[0]}', file=sys.stderr)
        return 1
    try:
        with context:
            _refuse_others(arguments)
            node = node_class()
            _report_unused_files(node, arguments)
            node.tell_of_ignored()
            notify = NotifySender()
            node.ended.add_done_callback(lambda ended: _set_once(stop, ended.result()))
            try:
                _notify_figures(node, notify)
                notify.send(READY=1)
                spin_guarded(node, stop)
            finally:
                notify.send(STOPPING=1, **_as_variables(node.figures))
                is_unfinished = node.close()
            return 1 if is_unfinished else stop.result()
    except BadParameter as error:
        print(f'refused: {error}', file=sys.stderr)
        return 1


def _as_variables(figures):
    return {f'X_FLAG_SIM_{name.upper()}': number for name, number in figures.items()}


def _notify_figures(node, notify):
    """Send the parent process, while the node runs, how many frames it has served."""
    if not notify.is_connected:
        return
    sent = {}

    def send():
        figures = node.figures
        if figures != sent and notify.send_progress(STATUS=f'{figures["frames"]} frames',
                                                    **_as_variables(figures)):
            sent.update(figures)
    node.create_timer(NOTIFY_EVERY, send)


def _report_unused_files(node, arguments):
    """Log which of the params files in `arguments` have nothing for the node."""
    name = node.get_fully_qualified_name()
    for path in given_files(arguments):
        try:
            keys = keys_in(path)
        except OSError:
            continue  # a pipe, which was read
        except ValueError as error:  # rclpy passes over a file that is one word
            node.get_logger().warning(str(error))
            continue
        if any(is_meant(key, name) for key in keys):
            continue
        text = (f'nothing in {path} is meant for {name}; it has parameters for '
                f'{", ".join(keys) or "nobody"}')
        namesakes = [key for key in keys if key.rpartition('/')[2] == node.get_name()]
        if namesakes:  # it was meant, but in another namespace
            node.get_logger().warning(
                f'{text}: all of it is ignored. /**/{node.get_name()} instead of {namesakes[0]} '
                'counts in every namespace')
        else:
            node.get_logger().info(text)


def _refuse_others(arguments):
    """Raise BadParameter for arguments that are not ROS's: rclpy passes over them."""
    others = remove_ros_args(arguments)[1:]
    if others:
        raise BadParameter(f"unknown arguments {' '.join(others)}; parameters are given as "
                           '--ros-args -p name:=value')


def _future_of_signals():
    """
    Return a future that SIGINT and SIGTERM set to 0; a second one ends the process at once.

    Python's handlers run only between two bytecodes of the main thread, which may wait inside
    the middleware forever; a byte on a socket reaches a thread of our own at any time.
    """
    stop = Future()
    reader, writer = _signal_sockets
    writer.setblocking(False)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(writer.fileno())

    def listen():
        reader.recv(1)
        _set_once(stop, 0)
        reader.recv(1)
        os._exit(1)
    threading.Thread(target=listen, daemon=True).start()
    return stop


def _set_once(future, status):
    if not future.done():
        future.set_result(status)
