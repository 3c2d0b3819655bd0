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

"""The viewer node: shows the flag in a window, in which people set the other nodes' parameters."""
from collections.abc import Sequence
import sys
import threading

from flag_sim.declarations.viewer import VIEWER
from flag_sim.protocol.cdr_image import read_image
from flag_sim.ros.frame_message import FrameReader
from flag_sim.ros.lifecycle import run
from flag_sim.ros.parameter_node import ParameterNode
from flag_sim.ros.remote_node import RemoteNode
from flag_sim.ros.roles import players
from flag_sim.ros.spinning import spin_guarded, why_no_events
from flag_sim.ros.topics import publish, subscribe
from flag_sim.viewer.exchange import Answered, Changed, Described, Exchange, Found, FramePlace
from flag_sim.viewer.exchange import Publish, Reported, Unreadable
from rcl_interfaces.msg import ParameterEvent
from rclpy.qos import qos_profile_parameter_events
from rclpy.task import Future
from std_msgs.msg import Empty

LOOK_PERIOD = 0.5
"""How often to look which nodes are there [s]."""
NO_QT = """\
the window needs Qt, which is not installed: {reason}
With ROS: sudo apt install python3-qtpy python3-pyqt5; without: pip install '.[viewer]' in the
folder of flag_sim's sources, or pip install qtpy PySide6-Essentials"""


class Viewer(ParameterNode):
    """
    Shows what the renderer draws in a window with the parameters and keys of all nodes.

    It is a client like any other: it subscribes to topics, and reads and sets parameters by the
    services of the nodes, which it knows by what they publish. What comes is left in `exchange`
    for the window, which has a thread of its own.
    """

    def __init__(self):
        super().__init__('viewer', VIEWER)
        self.exchange = Exchange()
        self._reader = FrameReader()
        self._out = {name: publish(self, name) for name in ('reset', 'step')}
        self._found = {}    # {role: (full name, endpoint)}
        self._remotes = {}  # {full name: RemoteNode}
        subscribe(self, 'camera/image_raw', self._on_image, raw=True)
        subscribe(self, 'parameters', self._on_frame, raw=True)
        subscribe(self, 'state', self._on_state)
        self.create_subscription(ParameterEvent, '/parameter_events', self._on_event,
                                 qos_profile_parameter_events)
        self.create_timer(LOOK_PERIOD, self._look)
        # An EventsExecutor refuses these; what it has in their place is `defer`.
        self._asked = (self.create_guard_condition(self.guarded(self._serve))
                       if why_no_events() else None)
        self.exchange.wake_ros = self._wake

    # What comes.

    def _on_image(self, data):
        with self._stopwatch.measure('work'):
            try:
                picture = read_image(bytes(data))
            except ValueError as error:
                self._log.warn(f'an image is ignored: {error}', 'images')
                self.exchange.post(Unreadable(str(error)))
                return
            self.exchange.put_picture(picture)
        self._stopwatch.frames += 1

    def _on_frame(self, data):
        try:
            frame, _, _ = self._reader.read(data)
        except ValueError as error:
            self._log.warn(f'parameters of a frame are ignored: {error}', 'parameters')
            return
        self.exchange.put_place(FramePlace(
            frame.stamp, frame.take, None if frame.take is None else frame.index))

    def _on_state(self, message):
        for status in message.status:
            self.exchange.post(Reported(
                status.name, status.level == b'\x00', status.message,
                {pair.key: pair.value for pair in status.values}))

    def _on_event(self, event):
        if event.node in self._remotes:
            self._remotes[event.node].take_event(event)

    # Who is there.

    def _look(self):
        self._serve()
        found = players(self)
        if found != self._found:
            ends = _ends(found)
            for name, old in _ends(self._found).items():
                if old != ends.get(name):  # gone, or started again
                    self._remotes.pop(name).close()
            for name, _ in found.values():
                if name not in self._remotes:
                    self._remotes[name] = self._remote(name)
            self._found = found
            self.exchange.post(Found({role: name for role, (name, _) in found.items()}))
        for remote in self._remotes.values():
            remote.look()

    def _remote(self, name):
        return RemoteNode(
            self, name, lambda descriptors, values: self.exchange.post(
                Described(name, descriptors, values)),
            lambda values, deleted: self.exchange.post(Changed(name, values, deleted)))

    # What the window asks for.

    def _wake(self):
        """Let the thread that runs this node look for what the window asks."""
        defer = self.defer
        if defer is not None:
            defer(self.guarded(self._serve))
        elif self._asked is not None:
            self._asked.trigger()

    def _serve(self):
        for request in self.exchange.requests():
            if isinstance(request, Publish):
                self._out[request.topic].publish(Empty())
                continue
            remote = self._remotes.get(request.node)
            kinds = {name: one.kind for name, one in request.descriptors.items()}

            def answer(reasons, token=request.token):
                self.exchange.post(Answered(token, reasons))
            if remote is None:
                answer(dict.fromkeys(request.values, f'{request.node} is not there'))
            else:
                remote.put(request.values, kinds, request.together, answer)

    def close(self) -> None:
        """Log where the time went."""
        self.exchange.wake_ros = None
        self.get_logger().info(f'{self._stopwatch.summary()}; {self.exchange.left_out} pictures '
                               'were left out, as the window was busy')


def _ends(found):
    """Return {full name: its endpoints} of those who play a role."""
    ends = {}
    for name, endpoint in found.values():
        ends.setdefault(name, set()).add(endpoint)
    return ends


def spin_with_window(node: Viewer, until: Future) -> None:
    """Run a node's callbacks in a thread, and its window here, until either is told to end."""
    # Qt is only known where there is a window: --help and the tests of the node do without.
    from flag_sim.viewer.application import run_window
    end = Future()

    def spin():
        spin_guarded(node, end)
        end_with(0)  # where ROS is shut down the window has nothing left to show

    def end_with(status):
        if not until.done():
            until.set_result(status)
    thread = threading.Thread(target=spin, name='ROS')
    thread.start()
    try:
        end_with(run_window(node.exchange, node.values['screenshot'], until.add_done_callback))
    finally:
        end.set_result(None)
        thread.join()


def why_no_window() -> str:
    """Return in words why there can be no window, or ''."""
    try:
        from flag_sim.viewer.application import why_no_display, why_unsound
    except ImportError as error:
        return NO_QT.format(reason=error)
    except Exception as error:  # qtpy's own, where it finds no binding
        if type(error).__module__.partition('.')[0] != 'qtpy':
            raise
        return NO_QT.format(reason=error)
    return why_unsound() or why_no_display()


def main(args: Sequence[str] | None = None) -> int:
    """Run the viewer node and its window; return the exit status."""
    return run(Viewer, args, spin_with_window, why_no_window)


if __name__ == '__main__':
    sys.exit(main())
