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

"""Checks of arrays of points that people give for a picture."""
from flag_sim.parameters import checks

import numpy as np


def points(name: str, value, shape: tuple) -> np.ndarray:
    """
    Return an array of real numbers of a shape, in which None stands for any length.

    Numbers may be missing (nan) or infinite. Raises ValueError for other shapes and types.
    """
    array = np.asarray(value)
    if array.dtype.kind not in 'fiu':
        checks.require(False, name, 'an array of real numbers',
                       value if array.dtype.kind == 'O' else array.dtype.name)
    is_fit = len(array.shape) == len(shape)
    for want, have in zip(shape, array.shape):
        is_fit &= want is None or want == have
    if not is_fit:
        words = str(shape).replace('None', 'any')
        checks.require(False, name, f'of shape {words}', array.shape)
    return array
