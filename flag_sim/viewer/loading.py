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

"""Loads a params file into the nodes that are there: all of it, or nothing."""
from collections.abc import Callable
import difflib
from pathlib import Path

from flag_sim.viewer import shot_files
from flag_sim.viewer.graph_model import GraphModel
from flag_sim.viewer.timeline_model import SHOWN, TimelineModel

ORDER = ('physics', 'renderer', 'wind')
"""The wind is the last: tracks of a file are not begun where another node refuses its part."""
NOT_DESCRIBED = (*SHOWN, 'qos_overrides.')
"""How names begin that a node may read although it does not declare them."""
LONGEST_NAME = 80
"""Characters of a name for which the nearest known one is looked for: it takes a while."""


class Loader:
    """
    Sets what params files hold, node after node, each all of its part or nothing.

    What the earlier nodes had is set again where a later one refuses. What the wind had can be
    undone on the timeline. say(text): tells at the end what was set, or who refused what.
    """

    def __init__(self, model: GraphModel, timeline: TimelineModel, say: Callable[[str], None]):
        self._model = model
        self._timeline = timeline
        self._say = say
        self._unused = ''  # what in the file that is loaded no node reads, in words

    def load(self, path: Path) -> None:
        """Set what a params file holds for the nodes that are there."""
        try:
            sections = shot_files.read_sections(path)
        except (OSError, ValueError) as error:
            self._say(f'{Path(path).name} was not loaded: {error}')
            return
        own = {role: shot_files.meant_for(sections, self._model.nodes[role], role)
               for role in ORDER if self._model.is_known(role)}
        parts = {role: self._part(role, sections) for role in own}
        parts = {role: values for role, values in parts.items() if values}
        self._unused = ''.join(f'; {words}' for words in self._unused_words(sections, own))
        if parts:
            self._put_next(Path(path).name, parts, {})
        else:
            self._say(f'{Path(path).name} has nothing for the nodes that are there{self._unused}')

    def _part(self, role, sections):
        values = shot_files.values_for(sections, self._model.nodes[role], role)
        if role == 'wind':
            values = shot_files.wind_values(values)
        return {name: value for name, value in values.items() if self._can_set(role, name)}

    def _unused_words(self, sections, own):
        """Yield in words which names in a file no node here reads."""
        for role, sections_of_role in own.items():
            known = self._model.descriptors[self._model.nodes[role]]
            for key, values in sections_of_role.items():
                for name in values if not shot_files.is_for_all(key) else ():
                    if not name.startswith(NOT_DESCRIBED) and name not in known:
                        near = difflib.get_close_matches(name[:LONGEST_NAME], known, n=1)
                        yield f'{role} has no {name}' + (f' ({near[0]}?)' if near else '')
        strange = [key for key in sections if not shot_files.is_for_all(key)
                   and not any(key in of_role for of_role in own.values())]
        if strange:
            yield f'no node here is {", ".join(strange)}'

    def _can_set(self, role, name):
        descriptor = self._model.descriptor(role, name)
        if descriptor is None:
            return role == 'wind' and name.startswith(SHOWN)  # keys of a track that is new
        return not descriptor.is_fixed

    def _put_next(self, file, parts, before):
        """Set the first part that has not been set yet; before: {role: what the others had}."""
        role = next(role for role in parts if role not in before)
        had = {name: self._model.value(role, name) for name in parts[role]}
        tracks = self._model.value('wind', 'tracks', [])

        def answer(reason):
            if reason:
                for other, values in before.items():
                    self._model.put_together(other, values, lambda _: None)
                self._say(f'{file} was not loaded: {role}: {reason}')
            elif len(before) + 1 < len(parts):
                self._put_next(file, parts, {**before, role: had})
            else:
                self._loaded(file, parts, tracks)
        if role == 'wind':
            self._timeline.load(f'load {file}', parts[role], answer)
        else:
            self._model.put_together(role, parts[role], answer)

    def _loaded(self, file, parts, tracks):
        wind = parts.get('wind', {})
        gone = [name for name in tracks if name not in wind.get('tracks', tracks)]
        self._say(f'{file}: set for ' + ', '.join(
            f'{role}: {len(values)}' for role, values in parts.items()) + self._unused + (
            f'; no longer played: {", ".join(gone)} (Ctrl+Z brings the keys back)' if gone
            else ''))
        if any(name.startswith(SHOWN) for name in wind):
            self._model.publish('reset')
