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

"""QoS overrides: parameters that change the quality of service of a node's topics at its start."""
import difflib

from rclpy.node import Node

PREFIX = 'qos_overrides.'
CHOICES = {
    'history': ('keep_last', 'keep_all', 'system_default'),
    'reliability': ('reliable', 'best_effort', 'system_default', 'best_available'),
}
"""What rclpy lets be set of the policies; it ends with a traceback for anything else."""
MAX_DEPTH = 2**31 - 1
"""Of a history [messages]."""


def _given(node):
    # rclpy's private record of what was given at the start; see ParameterNode.
    return {name: parameter.value for name, parameter in node._parameter_overrides.items()
            if name.startswith(PREFIX)}


def check_overrides(node: Node, topic: str, end: str) -> None:
    """
    Raise ValueError for a value that a policy of an end of a topic cannot have.

    topic: the full name; end: 'publisher' or 'subscription'.
    """
    for name, value in _given(node).items():
        entity, _, policy = name.rpartition('.')
        if entity != f'{PREFIX}{topic}.{end}':
            continue
        if policy in CHOICES and str(value).lower() not in CHOICES[policy]:
            raise ValueError(f'{name} must be one of {", ".join(CHOICES[policy])}, not {value!r}')
        if policy == 'depth' and not (type(value) is int and 1 <= value <= MAX_DEPTH):
            raise ValueError(f'{name} must be a whole number from 1 to {MAX_DEPTH} [messages], '
                             f'not {value!r}')


def ignored_overrides(node: Node) -> list[str]:
    """Return in words, for each override that no topic of a complete node takes, why."""
    known = [f'{PREFIX}{name}' for name in node.get_parameters_by_prefix(PREFIX[:-1])]
    return [f"parameter '{name}' is ignored: {_cause(name, known)}"
            for name in _given(node) if name not in known]


def _cause(name, known):
    entity = name.rpartition('.')[0]
    policies = sorted(other.rpartition('.')[2] for other in known
                      if other.rpartition('.')[0] == entity)
    if policies:
        return f'of this one {", ".join(policies)} can be set'
    near = difflib.get_close_matches(name, known, n=1)
    return 'this node lets no such topic and policy be set' + (
        f"; the nearest that it does is '{near[0]}'" if near else '')
