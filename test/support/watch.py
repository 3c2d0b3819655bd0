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

"""A node of the tests' own that listens, talks and sets parameters beside the real ones."""
import contextlib
import time

from flag_sim.ros.dds_profile import set_dds_profile
from flag_sim.ros.parameter_node import to_parameter
from flag_sim.ros.topics import publish, subscribe
from rcl_interfaces.srv import DescribeParameters
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

PATIENCE = 90.0  # after which what did not come is thought never to come [s]
ASK_AGAIN = 10.0  # after which what was not answered is asked for again [s]


class InVain(AssertionError):
    """What was waited for did not come."""


class Voice:
    """A publisher whose publish returns None: `publish(x) or heard` waits for what is heard."""

    def __init__(self, publisher):
        self._publisher = publisher

    def publish(self, message):
        """Send a message; fail if it does not leave."""
        assert self._publisher.publish(message)

    def __getattr__(self, name):
        """Return what else the publisher has."""
        return getattr(self._publisher, name)


class Watcher:
    """A node in a ROS context and a domain of its own; it is spun while it waits."""

    def __init__(self, domain):
        set_dds_profile()
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = Node('watcher', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def spin(self, seconds=0.05):
        """Let messages come in for a while."""
        self._executor.spin_once(timeout_sec=seconds)

    def publisher(self, topic):
        """Return a publisher of one of the package's topics."""
        return Voice(publish(self.node, topic))

    def listen(self, topic):
        """Return a list that grows with every message on one of the package's topics."""
        heard = []
        subscribe(self.node, topic, heard.append)
        return heard

    def parameters_of(self, node, *voices):
        """
        Return a client of a node's parameters, once the node has answered it.

        The node then knows all that this watcher had made before, as DDS tells it of that in the
        same order: what the node publishes once is heard, and the node hears what is published
        once by each of `voices`, on topics to which nobody else subscribes.
        """
        client = AsyncParameterClient(self.node, node)
        # Made after all of that client's own, none of which is asked for an answer here.
        last = self.node.create_client(DescribeParameters, f'{node}/describe_parameters')
        eventually(lambda: client.services_are_ready() and last.service_is_ready(), self)
        self._read(lambda: last.call_async(DescribeParameters.Request(names=['use_sim_time'])))
        eventually(lambda: all(voice.get_subscription_count() for voice in voices), self)
        return client

    def _result(self, future):
        eventually(future.done, self)
        return future.result()

    def _read(self, ask):
        """
        Return the result of what `ask` asks for, and ask again where no answer comes.

        A server that has not yet found the client's end of the service answers to nobody; reading
        twice does no harm.
        """
        for _ in range(round(PATIENCE / ASK_AGAIN)):
            future = ask()
            with contextlib.suppress(InVain):
                eventually(future.done, self, ASK_AGAIN)
                return future.result()
        raise InVain('asked in vain')

    def get(self, client, name):
        """Return the value of a parameter."""
        values = self._read(lambda: client.get_parameters([name])).values
        return parameter_value_to_python(values[0])

    def put(self, client, name, value):
        """Set a parameter as `ros2 param set` does; return the result."""
        return self.load(client, {name: value})[0]

    def load(self, client, values):
        """Set parameters {name: value} as `ros2 param load` does; return the results."""
        parameters = [to_parameter(name, value) for name, value in values.items()]
        return self._result(client.set_parameters(parameters)).results

    def put_atomically(self, client, values):
        """Set parameters {name: value} by the service set_parameters_atomically."""
        parameters = [to_parameter(name, value) for name, value in values.items()]
        return self._result(client.set_parameters_atomically(parameters)).result

    def get_all(self, client):
        """Return {name: value} of all parameters, as `ros2 param dump` does."""
        names = self._read(lambda: client.list_parameters([], 10)).result.names
        values = self._read(lambda: client.get_parameters(names)).values
        return {name: parameter_value_to_python(value) for name, value in zip(names, values)}

    def __enter__(self):
        """Return self."""
        return self

    def __exit__(self, *_):
        """Leave the graph."""
        self._executor.shutdown()
        rclpy.shutdown(context=self._context)


def eventually(condition, watcher, seconds=PATIENCE):
    """Spin until `condition()` holds; fail if it does not in time."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() >= end:
            raise InVain('waited in vain')
        watcher.spin()
