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

"""Autokey: what a user sets on any node while a shot plays becomes a key (the source's 1.5)."""
from flag_sim.declarations import keys
from flag_sim.ros.parameter_node import to_parameter


class Autokey:
    """
    Keys, while `autokey` is on, every change on a companion or the wind that can be keyed.

    node: the wind; now(): where in the animation it is [s]. Playback sets no parameter, so it is
    never heard here.
    """

    def __init__(self, node, now):
        self._node = node
        self._now = now
        node.companions.on_change = self._on_change

    def _on_change(self, changes):
        """Key what can be keyed of [(node, name, value, value before)]; save what cannot."""
        keyed = [self._put_key(f'{node}.{name}', value, old) for node, name, value, old in changes
                 if self._node.values['autokey'] and _is_keyed(f'{node}.{name}')]
        # A key is saved with all that the nodes have, and the wind saves what is set on itself.
        if not any(keyed) and any(node != 'wind' for node, *_ in changes):
            self._node.save()

    def _put_key(self, track, value, old):
        """Make a key of what a user has set, if it is one; return whether there is a new key."""
        values = self._node.values
        try:
            changes = keys.with_key(values, track, self._now(), value, old, 0.5 / values['rate'])
        except ValueError as error:
            self._node.get_logger().warning(f'no key is made: {error}')
            return False
        if not changes:
            return False
        result = self._node.set_parameters_atomically(
            [to_parameter(name, new) for name, new in changes.items()])
        if not result.successful:
            self._node.get_logger().warning(f'no key is made: {result.reason}')
        return result.successful


def _is_keyed(track):
    try:
        keys.target_declaration(track)
    except ValueError:
        return False
    return True
