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

"""Which parameters of the nodes a recipe may set, and the declaration of each."""
from collections.abc import Mapping

from flag_sim.animation.wind_source import PARAMETERS as OF_THE_WIND
from flag_sim.declarations.nodes import named, scene

FILMED = ('wind', 'physics', 'renderer')
"""The nodes whose parameters make a clip."""
SCENE = 'scene'
"""In a recipe: the parameters that physics and renderer share, which must not differ."""
WITHOUT_EFFECT = {
    'wind': 'it says how the node sends its frames',
    'physics': 'it changes nothing of the clip', 'renderer': 'it changes nothing of the clip'}
_MORE_OF_THE_WIND = ('loop', 'snap_keys')
_NOT_OF_THE_CLIP = ('threads', 'compressed.format', 'compressed.jpeg_quality')
ONE_SIZE = ('width', 'height', 'grid.rows', 'grid.columns')
"""What cannot be keyed: within a clip all frames are of one size."""


def declarations() -> dict[str, object]:
    """Return {node.parameter: declaration} of all that a recipe may set."""
    shared = {one.name: one for one in scene()}
    found = {f'{SCENE}.{name}': one for name, one in shared.items()}
    for node in FILMED:
        for name, one in named(node).items():
            is_other = (name not in (*OF_THE_WIND, *_MORE_OF_THE_WIND) if node == 'wind' else
                        name in shared or name in _NOT_OF_THE_CLIP)
            if not is_other:
                found[f'{node}.{name}'] = one
    return found


def refusal(name: str) -> str:
    """Return in words why a recipe cannot set a parameter, though a node may have it."""
    node, _, own = name.partition('.')
    if node not in FILMED:
        return (f'{name}: a parameter is named node.parameter, the node being one of '
                f'{", ".join(FILMED)}, or scene.parameter for what physics and renderer share')
    if own not in named(node):
        return f'{name}: {node} has no parameter {own!r}'
    if own in {one.name for one in scene()}:
        return f'{name}: physics and renderer share it; name it {SCENE}.{own}'
    if own in ('rate', 'frames'):
        return f'{name}: the recipe has {own} as an entry of its own'
    if own == 'tracks' or own.startswith('events.'):
        return f'{name}: keys are in the entry tracks of the recipe'
    return f'{name}: it cannot be set, {WITHOUT_EFFECT[node]}'


def spread(values: Mapping) -> dict[str, dict]:
    """Return {node: {parameter: value}} of a recipe's {node.parameter: value}."""
    found = {node: {} for node in FILMED}
    for name, value in values.items():
        node, _, own = name.partition('.')
        for each in ('physics', 'renderer') if node == SCENE else (node,):
            found[each][own] = value
    return found
