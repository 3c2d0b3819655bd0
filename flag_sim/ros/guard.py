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

"""Guards: what a callback or the middleware raises is told once, and the node goes on."""
from collections.abc import Callable
from pathlib import Path
import traceback

from flag_sim.protocol.throttled_log import Entry
from flag_sim.ros.node_log import NodeLog
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.task import Future


def cause(error: Exception) -> str:
    """Return what was raised and where, in one line."""
    where = traceback.extract_tb(error.__traceback__)
    place = f' ({Path(where[-1].filename).name}:{where[-1].lineno})' if where else ''
    # The place stands first: what a stranger has sent may be long.
    return f'{type(error).__name__}{place}: {error}'


def spin_guarded(node: Node, until: Future, spin_once: Callable[[], None] | None = None) -> None:
    """
    Run a node's callbacks until a future is done or its context is shut down.

    What one of them raises, whatever it was sent, is logged once a cause, and the next one runs.
    spin_once(): runs one callback; by default that of an executor of its own.
    """
    if spin_once is not None:
        _spin(node, until, spin_once)
        return
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    # A task of its own, so that it returns: an executor that is only woken waits on.
    until.add_done_callback(lambda _: executor.create_task(lambda: None))
    try:
        _spin(node, until, executor.spin_once)
    finally:  # now, for it cannot be done any more when the interpreter ends
        executor.shutdown()


def _spin(node, until, spin_once):
    log = NodeLog(node)
    while node.context.ok() and not until.done():
        try:
            spin_once()
        except Exception as error:
            if not node.context.ok():
                return
            log.error(f'a callback failed, the node goes on: {cause(error)}', 'callbacks')
            _release(node)


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


class GuardedPublisher:
    """
    A publisher of `node` whose `publish` raises nothing and returns whether the message has left.

    What the middleware says is logged once a cause. Everything else is as of the rclpy publisher.
    """

    def __init__(self, node: Node, publisher: Publisher):
        self._publisher = publisher
        self._log = NodeLog(node)

    def publish(self, message: object) -> bool:
        """Send a message, or bytes that are one; return whether it has left."""
        try:
            self._publisher.publish(message)
        except Exception as error:
            self._log.write_once(Entry(
                'warning', f'a message on {self._publisher.topic_name} could not be sent: '
                f'{cause(error)}'))
            return False
        return True

    def __getattr__(self, name: str) -> object:
        """Return what is not ours from the rclpy publisher."""
        return getattr(self._publisher, name)
