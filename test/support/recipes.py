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

"""Small recipes for tests."""
from flag_sim.dataset.recipe import recipe_of

SMALL = """\
seed: 7
clips: 3
frames: 4
channels: [vertices, wind]
parameters:
  wind.speed: {uniform: [3.0, 14.0]}
  physics.grid.columns: 7
  physics.grid.rows: 5
"""
SEEN = """
  renderer.width: 64
  renderer.height: 48
"""


def text(changes=(), channels=None, more=''):
    """Return the text of a small recipe; changes: {from: to} in it; more: lines at its end."""
    found = SMALL
    for old, new in dict(changes).items():
        assert old in found
        found = found.replace(old, new)
    if channels:
        found = found.replace('[vertices, wind]', f'[{", ".join(channels)}]')
        found += SEEN
    return found + more


def recipe(changes=(), channels=None, more=''):
    """Return the Recipe of such a text."""
    return recipe_of(text(changes, channels, more))
