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

"""
Random numbers of a clip, the same whoever draws them, and whatever else is drawn.

They are Philox's, a generator that counts (Salmon et al., 2011): its key is (seed of the recipe,
number of the clip), and its counter begins at a place of its own for each name. So the clips need
not be made in any order, and a parameter that is added to a recipe leaves the others as they were.
numpy promises that the bits of a generator stay what they are, and not its distributions: those
are made here.
"""
import hashlib

import numpy as np

MOST_SEED = 2**63 - 1
"""Greatest seed of a recipe."""


class Stream:
    """The random numbers of one name in one clip; seed: of the recipe; clip: the clip's number."""

    def __init__(self, seed: int, clip: int, name: str):
        place = int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], 'little')
        self._bits = np.random.Philox(key=np.array([seed, clip], np.uint64),
                                      counter=np.array([0, 0, 0, place], np.uint64))

    def unit(self) -> float:
        """Return a number from 0 to below 1, each multiple of 2^-53 as likely."""
        return (int(self._bits.random_raw()) >> 11) * 2.0**-53

    def whole(self, count: int) -> int:
        """Return a whole number from 0 to below count, at most 2^63."""
        return int(self._bits.random_raw()) * count >> 64
