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

"""Files damaged as disks, copies and strangers do it: bits, holes, cuts, swaps, foreign parts."""
import os

from hypothesis import HealthCheck, settings, strategies

LONG = int(os.environ.get('FLAG_SIM_DAMAGED', '0'))
"""How many inputs of each kind `make soak` tries."""
FOREIGN = (
    b'*a', b'&a ', b'!!binary ', b'!!python/object/apply:os.system ', b'[', b'{', b'- ', b': ',
    b'\n', b'"', b'|', b'---\n', b'1e400', b'.nan', b'9' * 40, b'\xff\xfe', b'\0' * 9, b'[1, a]',
    b'/**', b'? ', b'<<', b'\xff' * 8, b'\x7f' + b'\xff' * 7, b'\x89MCAP0\r\n', b'zstd')
"""Parts that mean something to one of the formats."""


def damaged(whole: bytes) -> strategies.SearchStrategy:
    """Return the strategy of a file that was `whole`, after one to four kinds of damage."""
    places = strategies.integers(0, len(whole))
    damage = strategies.one_of(
        strategies.tuples(strategies.just('set'), places, strategies.integers(0, 255)),
        strategies.tuples(strategies.just('put'), places, strategies.sampled_from(FOREIGN)),
        strategies.tuples(strategies.just('over'), places, strategies.sampled_from(FOREIGN)),
        strategies.tuples(strategies.just('hole'), places, strategies.integers(1, 300)),
        strategies.tuples(strategies.just('zero'), places, strategies.integers(1, 300)),
        strategies.tuples(strategies.just('again'), places, places),
        strategies.tuples(strategies.just('cut'), places, places))

    def build(steps):
        data = bytearray(whole)
        for kind, place, what in steps:
            if kind == 'set' and place < len(data):
                data[place] = what
            elif kind == 'put':
                data[place:place] = what
            elif kind == 'over':
                data[place:place + len(what)] = what
            elif kind == 'hole':
                del data[place:place + what]
            elif kind == 'zero':
                data[place:place + what] = bytes(len(data[place:place + what]))
            elif kind == 'again':
                data[place:place] = data[what:what + 200]
            elif kind == 'cut':
                del data[place:]
        return bytes(data)
    return strategies.lists(damage, min_size=1, max_size=4).map(build)


def inputs(short: int) -> settings:
    """Return hypothesis's settings for so many inputs, or as many as `make soak` asks for."""
    return settings(max_examples=LONG or short, deadline=None, derandomize=not LONG,
                    database=None, suppress_health_check=list(HealthCheck))
