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

"""Parameters that need one another, set by one request of `set_parameters`: all or none."""
from collections.abc import Callable

from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService


class GroupParameterService(ParameterService):
    """
    A node's parameter services, of which `set_parameters` knows a group.

    is_part(name): whether a parameter is one of the group. rclpy's own sets one after another, so
    that a file of `ros2 param load` would be refused at the first list that does not fit those
    that follow it. Here the parts in a request are set at once, and the others as by rclpy.
    """

    def __init__(self, node: Node, is_part: Callable[[str], bool]):
        self._node = node
        self._is_part = is_part
        super().__init__(node)

    def _set_parameters_callback(self, request, response):
        group = [message for message in request.parameters if self._is_part(message.name)]
        of_group = self._set(group) if group else None
        response.results = [of_group if self._is_part(message.name) else self._set([message])
                            for message in request.parameters]
        return response

    def _set(self, messages):
        return self._node.set_parameters_atomically(
            [Parameter.from_parameter_msg(message) for message in messages])
