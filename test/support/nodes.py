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

"""A node of the package in this process, and its services as requests reach them."""
import contextlib
import importlib
from unittest import mock

from flag_sim.ros.bag import Bag
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.serialization import serialize_message


SENDER = {'publisher_gid': {'data': [0] * 16}}


@contextlib.contextmanager
def unguarded(node):
    """Let what callbacks of a node raise out of them."""
    def throw(error):
        raise error
    with mock.patch.object(node, 'report', throw):
        yield


def call(node, request):
    """Return what a service of a node answers to a request; nothing goes over the network."""
    service = next(service for service in node.services
                   if isinstance(request, service.srv_type.Request))
    with unguarded(node):
        return service.callback(request, service.srv_type.Response())


def hear(node, topic, message, info=None):
    """Let a message arrive at a node, as its executor would hand it over."""
    subscription = next(one for one in node.subscriptions if one.topic_name == f'/{topic}')
    with unguarded(node):
        subscription.callback(serialize_message(message), info or SENDER)


@contextlib.contextmanager
def made(name, domain, folder, *arguments):
    """Yield a node by its name, with what it needs in a folder."""
    module = importlib.import_module(f'flag_sim.nodes.{name}')
    path = folder / 'bag'
    if name == 'player':
        bag = Bag(path, 'mcap', 'none')
        bag.add_topic('/parameters', ParameterEvent)
        bag.close()
    given = [*arguments, f'path:={path}'] if name in ('player', 'recorder') else arguments
    parts = [part for one in given for part in ('-p', one)]
    with rclpy.init(domain_id=domain, args=['--ros-args', *parts]):
        node = getattr(module, name.capitalize())()
        try:
            yield node
        finally:
            node.close()
            node.destroy_node()
