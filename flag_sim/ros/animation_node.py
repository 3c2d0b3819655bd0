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

"""A node whose parameters hold an animation: read, checked, changed as a whole, and saved."""
from collections.abc import Iterable, Mapping

from flag_sim.animation import keys
from flag_sim.animation.autokey import with_key
from flag_sim.animation.timeline import Timeline
from flag_sim.declarations.keyable import TARGETS
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.params_file import (
    check_path, check_within, save_parameters, start_folder)
from flag_sim.protocol.throttled_log import Entry
from flag_sim.ros.companions import COMPANIONS, Companions
from flag_sim.ros.parameter_node import BadParameter, ParameterNode, to_parameter


def is_part(name: str) -> bool:
    """Return whether a parameter is part of the animation, in which one part needs the others."""
    return name.startswith(('tracks', 'keys.', 'events.'))


class AnimationNode(ParameterNode):
    """
    Reads its `timeline` from its parameters, at the start and whenever they change.

    With `save_to` it saves the whole shot after every change, its own and its companions'. With
    `autokey` every change on a companion or on the node itself that can be keyed becomes a key at
    the present time; playback sets no parameter, so it makes none.
    Derived nodes define `now`, and extend `apply` by what else changes.
    """

    def __init__(self, name: str, declarations: Iterable[Declaration]):
        self._read = None, None  # the parts that were read last, and their Timeline
        self._made = {}          # the tracks of that reading
        self._warned = set()     # the tracks whose present keys have been warned of
        super().__init__(name, declarations, allow_undeclared_parameters=True)
        self.timeline = self._timeline_of(self.values)
        self._warn_of_keys()
        try:
            self._save_folder = start_folder(self.values['save_to'])
        except ValueError as error:
            raise BadParameter(str(error)) from None
        self._file = None, None  # the path that was saved last, and which file it is
        self._trouble = ''       # why the shot could not be saved, as it was said
        self._saved = None  # the companions that are in the file that was saved last
        self.companions = Companions(self, self._on_answer, self._on_change)

    def now(self) -> float:
        """Return the time of the last frame in the animation [s]."""
        raise NotImplementedError

    def _timeline_of(self, values) -> Timeline:
        """Return the Timeline of values {name: value}; raise ValueError if it cannot be played."""
        # Not of the rate where it changes nothing: a new timeline is another wind.
        more = ['loop', 'snap_keys', *['rate'] * values['snap_keys']]
        parts = {name: value for name, value in values.items() if is_part(name) or name in more}
        if parts != self._read[0]:  # ten thousand keys take a while
            self._read = parts, keys.read_timeline(values, TARGETS, self._made)
        return self._read[1]

    def _warn_of_keys(self):
        """Warn once of keys that may not do what their user expects."""
        found = keys.warnings(self.timeline)
        for name in found.keys() - self._warned:
            self._log.write_few(Entry('warning', found[name]), 'keys')
        self._warned = set(found)

    # Parameters.

    def is_part(self, name: str) -> bool:
        """Return whether a parameter is part of the animation."""
        return is_part(name)

    def adopt(self, given: dict) -> None:
        """Take the keys of all tracks, those too that are not named in `tracks` yet."""
        for name in sorted(name for name in given if keys.is_key_name(name)):
            self.values[name] = self.accept(name, given.pop(name))
            self.store([to_parameter(name, self.values[name], self.item_of(name))])
            if keys.track_of(name) not in self.values['tracks']:
                self.get_logger().warning(f"{name}: no track '{keys.track_of(name)}' is named in "
                                          'tracks, so it is not played')

    def accept(self, name: str, value: object) -> object:
        """Accept keys beside what is declared, and a path only if it can be written."""
        if keys.is_key_name(name):
            return keys.accept_keys(name, value, TARGETS)
        value = super().accept(name, value)
        if name == 'save_to' and value:
            check_path(value, (self.get_name(), *COMPANIONS))
        return value

    def accept_change(self, name: str, value: object) -> object:
        """Accept of paths, while the node runs, only those in the folder that it started with."""
        if name == 'save_to' and isinstance(value, str) and value not in ('', self.values[name]):
            check_within(value, self._save_folder)
        return super().accept_change(name, value)

    def item_of(self, name: str) -> type:
        """Return the type of what a list of keys holds; of others as they are declared."""
        return (keys.item_of(name, TARGETS) if keys.is_key_name(name)
                else super().item_of(name))

    def check_deletion(self, name: str) -> None:
        """Let keys be deleted; `check` refuses it where a track plays them."""
        if not keys.is_key_name(name):
            super().check_deletion(name)
        elif name not in self.values:
            raise ValueError(f"no parameter '{name}'")

    def check(self, values: Mapping) -> None:
        """Raise ValueError for an animation that cannot be played."""
        self._timeline_of(values)

    def apply(self, changed: set[str]) -> None:
        """Play the new animation, and save it."""
        del changed
        self.timeline = self._timeline_of(self.values)
        self._warn_of_keys()
        self.save()

    # The file.

    def save(self) -> None:
        """Write the shot to `save_to`, if there is one."""
        if not self.values['save_to']:
            return
        others, lacking = self.companions.settings(
            keys.values_at(self.timeline, 0.0, TARGETS))
        self._saved = set(others)
        path = self.values['save_to']
        try:
            self._file = path, save_parameters(
                path, self.get_fully_qualified_name(), self.values, others, lacking, COMPANIONS,
                self._file[1] if self._file[0] == path else None)
            trouble = ''
        except (OSError, ValueError) as error:
            trouble = f'cannot save {path}: {getattr(error, "strerror", None) or error}'
        if trouble and trouble != self._trouble:  # once, however many changes follow
            self._log.error(trouble, 'file')
        self._trouble = trouble

    def _on_answer(self, companion):
        """Complete a file that was saved before this companion had sent its values."""
        if self._saved is not None and companion not in self._saved:
            self.save()

    # Autokey.

    def _on_change(self, changes):
        """Key what can be keyed of [(node, name, value, value before)]; save what cannot."""
        keyed = [self._put_key(TARGETS.track_of(node, name), value, old)
                 for node, name, value, old in changes
                 if self.values['autokey'] and TARGETS.track_of(node, name) in TARGETS]
        # A key is saved with all that the nodes have, and the node saves what is set on itself.
        if not any(keyed) and any(node != 'wind' for node, *_ in changes):
            self.save()

    def _put_key(self, track, value, old):
        """Make a key of what a user has set, if it is one; return whether there is a new key."""
        try:
            changes = with_key(self.values, track, self.now(), value, old,
                               reach=0.5 / self.values['rate'], targets=TARGETS,
                               present=self.timeline.tracks.get(track))
        except ValueError as error:
            self._log.warn(f'no key was made: {error}', 'autokey')
            return False
        if not changes:
            return False
        result = self.set_parameters_atomically(
            [to_parameter(name, new) for name, new in changes.items()])
        if not result.successful:
            self._log.warn(f'no key was made: {result.reason}', 'autokey')
        return result.successful
