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
from flag_sim.ros.intake import Intake, RequestIntake
from flag_sim.ros.node_log import NodeLog
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription


def cause(error: Exception) -> str:
    """Return what was raised and where, in one line."""
    where = traceback.extract_tb(error.__traceback__)
    place = f' ({Path(where[-1].filename).name}:{where[-1].lineno})' if where else ''
    # The place stands first: what a stranger has sent may be long.
    return f'{type(error).__name__}{place}: {error}'


class GuardedNode(Node):
    """
    A node whose timers, subscriptions and services raise nothing, whatever they are sent.

    What a callback raises is logged once a cause. An executor that sees it loses the events which
    it holds besides, and that of rclpy.experimental logs all of it each time.
    """

    def __init__(self, name: str, **options):
        self._fault_log = None
        # defer(function): how the executor runs something once all that has come so far is
        # served; None where that is not needed.
        self.defer: Callable | None = None
        super().__init__(name, **options)

    def report(self, error: Exception) -> None:
        """Log what a callback has raised, unless the node is ending."""
        if not self.context.ok():
            return
        if self._fault_log is None:  # rclpy's own subscriptions are made before there is a logger
            self._fault_log = NodeLog(self)
        self._fault_log.error(f'a callback failed, the node goes on: {cause(error)}', 'callbacks')

    def guarded(self, callback: Callable) -> Callable:
        """Return a callback that reports what it raises, and then returns None."""
        def call(*arguments):
            try:
                return callback(*arguments)
            except Exception as error:
                self.report(error)
        return call

    def create_timer(self, timer_period_sec, callback, *arguments, **options):
        """Return a timer as rclpy does."""
        call = self.guarded(callback)
        # rclpy gives its info to whatever takes an argument.
        return super().create_timer(timer_period_sec, lambda: call(), *arguments, **options)

    def create_subscription(self, msg_type, topic, callback, qos_profile, *, raw=False, **options):
        """Return a subscription as rclpy does; it takes all messages as bytes."""
        intake = Intake(self, msg_type, topic, callback, raw)
        return super().create_subscription(
            msg_type, topic, intake, qos_profile, raw=True, **options)

    def create_service(self, srv_type, srv_name, callback, **options):
        """Return a service as rclpy does; where its callback fails it answers with defaults."""
        call = self.guarded(callback)

        def answer(request, response):
            answered = call(request, response)
            return srv_type.Response() if answered is None else answered
        intake = RequestIntake(self, answer)
        service = super().create_service(srv_type, srv_name, intake, **options)
        intake.attach(service)
        return service

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher as rclpy does, but not while the node is run."""
        self._refuse_while_spun()
        return super().destroy_publisher(publisher)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription as rclpy does, but not while the node is run."""
        self._refuse_while_spun()
        return super().destroy_subscription(subscription)

    def _refuse_while_spun(self):
        if self.defer is not None:  # https://github.com/ros2/rclpy/issues/1644
            raise RuntimeError('what has event callbacks cannot be destroyed while an '
                               'EventsExecutor runs the node: it would crash')


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
