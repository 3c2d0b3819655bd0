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

"""The kernels of a picture that the renderer's parameters choose."""
from collections.abc import Mapping

from flag_sim.declarations.factories import look_of
from flag_sim.declarations.kernel_choice import KernelChoice
from flag_sim.declarations.renderer import RENDERER
from flag_sim.drawing import Picture
import numpy as np

DEFAULTS = {declaration.name: declaration.default for declaration in RENDERER}


def kernels_of(values: Mapping) -> str:
    """Return in words what the kernels are compiled for."""
    return 'the rasterizer with outlines' if values['outline'] else 'the rasterizer'


def warm_up(values: Mapping) -> None:
    """Compile or load the kernels before the first frame that needs them."""
    square = np.array([[[0.0, 0.0, 9.0], [1.0, 0.0, 9.0]], [[0.0, 0.0, 8.0], [1.0, 0.0, 8.0]]])
    Picture().draw(square, None, *look_of({**DEFAULTS, **values}))


PICTURE_KERNELS = KernelChoice(('outline',), kernels_of, warm_up)
