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

"""Who is who in a graph: nodes by what they publish, whatever their names and namespaces are."""
from flag_sim.ros.incompatible import UNKNOWN
from rclpy.node import Node

ROLES = {'wind': 'parameters', 'physics': 'vertices', 'renderer': 'camera/image_raw'}
"""The topic by which the node of each role is known."""


def players(node: Node) -> dict[str, tuple[str, bytes]]:
    """
    Return {role: (full name, GID of the endpoint)} of the nodes that publish its topic.

    Of several that publish one it is the one that is named as the role, or else one in `node`'s
    own namespace, or else the first by its name. A restart renews the GID; a node may play several
    roles.
    """
    found = {}
    for role, topic in ROLES.items():
        ends = {(f'{end.node_namespace.rstrip("/")}/{end.node_name}', bytes(end.endpoint_gid))
                for end in node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
                if end.node_name != UNKNOWN}
        if ends:
            own = f'{node.get_namespace().rstrip("/")}/'
            found[role] = min(ends, key=lambda end: (
                not end[0].endswith(f'/{role}'), not end[0].startswith(own), end))
    return found
