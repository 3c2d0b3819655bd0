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

"""A node's parameter services, which answer whatever they are asked."""
from collections.abc import Callable, Iterable

from flag_sim.protocol.throttled_log import shortened
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService


class CheckedParameterService(ParameterService):
    """
    The parameter services of `node`; parameters that need one another are set all or none.

    is_part(name): whether a parameter is one of such a group. rclpy's own sets one after another,
    so that a file of `ros2 param load` would be refused at the first list that does not fit those
    that follow it. Here the parts in a request are set at once, and the others one by one. What
    is no parameter at all, such as a value of a type that ROS does not know, is refused; rclpy's
    own raises there.
    """

    def __init__(self, node: Node, is_part: Callable[[str], bool] = lambda name: False):
        self._node = node
        self._is_part = is_part
        super().__init__(node)

    def _set_parameters_callback(self, request, response):
        group = [message for message in request.parameters if self._is_part(message.name)]
        of_group = self._set(group) if group else None
        response.results = [of_group if self._is_part(message.name) else self._set([message])
                            for message in request.parameters]
        return response

    def _set_parameters_atomically_callback(self, request, response):
        response.result = self._set(request.parameters)
        return response

    def _set(self, messages):
        try:
            parameters = _read(messages)
            return self._node.set_parameters_atomically(parameters)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=shortened(str(error)))


def _read(messages: Iterable) -> list[Parameter]:
    """Return rclpy's Parameters of messages; raise ValueError for what is none."""
    parameters = {}
    for message in messages:
        try:
            # Of several values of one parameter the last one counts.
            parameters[message.name] = Parameter.from_parameter_msg(message)
        except (TypeError, ValueError):
            raise ValueError(f"'{shortened(message.name)}' has a value of type "
                             f'{message.value.type}, which is no parameter type') from None
    return list(parameters.values())
