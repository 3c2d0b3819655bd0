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

"""Spinning a node: which executor runs its callbacks, and what outlives what they raise."""
from collections.abc import Callable, Iterator

from flag_sim.ros.guard import GuardedNode
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future
from rclpy.utilities import get_rmw_implementation_identifier

try:
    from rclpy.experimental import EventsExecutor
except ImportError:
    EventsExecutor = None

LONGEST_SPIN = 1e6
"""
How long the EventsExecutor is spun at a time [s].

Without a limit that of rclpy 9.1.2 waits until the latest time that its clock can hold, which
overflows: it comes back at once, and handles nothing.
"""
MOST_LEFT = 1000
"""Messages of a topic that are looked for after a fault; more are in no queue."""


def why_no_events() -> str:
    """Return why the EventsExecutor cannot be used, in words, or ''."""
    if EventsExecutor is None:
        return 'this rclpy has no EventsExecutor'
    if get_rmw_implementation_identifier() != 'rmw_fastrtps_cpp':
        return 'the EventsExecutor is tested with rmw_fastrtps_cpp only'
    return ''


def spin_guarded(node: GuardedNode, until: Future) -> None:
    """
    Run a node's callbacks until a future is done or its context is shut down.

    By the EventsExecutor, which waits for all at once, where that can be used; else by the
    SingleThreadedExecutor, which asks each entity before every callback.
    What the executor itself raises is logged once a cause, and the node goes on.
    """
    reason = why_no_events()
    if reason:
        node.get_logger().info(f'{reason}: callbacks are run by the SingleThreadedExecutor, which '
                               'takes more processor time')
        _spin_single(node, until)
    else:
        _spin_events(node, until)


def _spin_single(node, until):
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    # A task of its own, so that it returns: an executor that is only woken waits on.
    until.add_done_callback(lambda _: executor.create_task(lambda: None))
    try:
        while node.context.ok() and not until.done():
            try:
                executor.spin_once()
            except Exception as error:
                node.report(error)
                _release(node)
    finally:  # now, for it cannot be done any more when the interpreter ends
        executor.shutdown()


def _release(node):
    """
    Let all callbacks of a node run again, none of which is running now.

    rclpy leaves one that fails while its message is taken from the middleware marked as running,
    and its group with it: no other one of the group would ever be called again.
    """
    for entity in (*node.timers, *node.subscriptions, *node.guards, *node.clients,
                   *node.services, *node.waitables):
        group = entity.callback_group
        if getattr(entity, '_executor_event', False) and group is not None:
            entity._executor_event = False
            group.ending_execution(entity)


def _spin_events(node, until):
    executor = EventsExecutor(context=node.context)
    executor.add_node(node)
    node.defer = executor.create_task
    turns = [None]  # the future that ends the present turn, and nothing after the last one

    def end(_):
        if turns[0] is not None:
            turns[0].set_result(None)
    until.add_done_callback(end)
    try:
        while node.context.ok():
            # A future of its own each time: where the executor raises it leaves a pointer to
            # itself in the future.
            turns[0] = Future()
            if until.done():
                return
            try:
                executor.spin_until_future_complete(turns[0], LONGEST_SPIN)
            except Exception as error:
                node.report(error)
                _serve_left(node)
    finally:
        turns[0] = node.defer = None
        # It ends the process where it is deleted while it still has callbacks.
        executor.shutdown()


def _serve_left(node):
    """
    Serve what came with an event of which the executor has raised: it forgets the others.

    They would stay in the middleware, and everything after them would be served one too late.
    """
    for entity, take, serve in _entities(node):
        for _ in range(MOST_LEFT):
            try:
                with entity.handle:
                    taken = take()
                if taken is None or None in taken:
                    break
                serve(*taken)
            except Exception as error:
                node.report(error)


def _entities(node: GuardedNode) -> Iterator[tuple[object, Callable, Callable]]:
    """Yield (entity, take(), serve(what was taken)) of whatever may have been left."""
    for one in list(node.subscriptions):
        yield (one, lambda one=one: one.handle.take_message(one.msg_type, one.raw),
               one.callback)
    for one in list(node.services):
        yield (one, lambda one=one: one.handle.service_take_request(one.srv_type.Request),
               lambda request, header, one=one: one.send_response(
                   one.callback(request, one.srv_type.Response()), header))
