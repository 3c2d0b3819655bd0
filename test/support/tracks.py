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

"""Parameters of a wind that has tracks."""
from flag_sim.animation import keys
from flag_sim.declarations.nodes import defaults


def wind_values(**tracks):
    """Return the wind's default values with tracks {name: (times, values, laws or None)}."""
    values = defaults('wind')
    values['tracks'] = [name.replace('__', '.') for name in tracks]
    for name, parts in tracks.items():
        for part, value in zip(keys.PARTS, parts):
            if value is not None:
                values[keys.key_name(name.replace('__', '.'), part)] = value
    return values
