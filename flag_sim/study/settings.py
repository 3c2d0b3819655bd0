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

"""The settings of a study: the defaults of all three nodes' dials in one, and changes of them."""
from flag_sim.dials.catalogue import PHYSICS, RENDERER, SCENE, WIND
from flag_sim.drawing import Picture

SIZES = ('flag.length', 'flag.width')
"""The dials of the scene that are the cloth's."""


def _defaults(dials, but=()):
    """Return {dial: default}, lists as tuples, which cannot be changed by mistake."""
    return {dial.name: tuple(dial.default) if dial.is_list else dial.default
            for dial in dials if dial.name not in but}


WEATHER = {dial: default for dial, default in _defaults(WIND).items()
           if dial in ('rate', 'speed', 'azimuth', 'elevation') or dial.startswith('gust.')}
"""The wind node's dials that a frame depends on."""

DEFAULTS = {
    'wind': WEATHER,
    'physics': {**{dial: _defaults(SCENE)[dial] for dial in SIZES},
                **_defaults(PHYSICS, but=['max_gap', 'preroll'])},
    'renderer': {**_defaults(SCENE, but=SIZES), **_defaults(RENDERER, but=['threads']),
                 'drawing.threads': 1},
}
"""
{node: {dial: default}}: all that a frame depends on.

Both physics and renderer have `threads`: the renderer's is `drawing.threads` here.
"""


def defaults(**changes):
    """Return new settings: the defaults of all dials, changed; `__` in a name stands for a dot."""
    changes = {name.replace('__', '.'): value for name, value in changes.items()}
    return changed({name: value for dials in DEFAULTS.values() for name, value in dials.items()},
                   changes)


def changed(settings, changes):
    """Return settings with changes {dial: value}; raise ValueError for an unknown dial."""
    unknown = sorted(set(changes) - set(settings))
    if unknown:
        raise ValueError(f'there is no dial {", ".join(unknown)}')
    return {**settings, **changes}


def picture_of(settings):
    """Return a Picture that draws with the settings' threads."""
    return Picture(settings['drawing.threads'])
