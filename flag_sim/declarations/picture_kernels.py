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
import dataclasses

from flag_sim.declarations.factories import look_of
from flag_sim.declarations.kernel_choice import KernelChoice
from flag_sim.declarations.renderer import IMAGE, RENDERER
from flag_sim.drawing import Light, Picture, Texture
import numpy as np

DEFAULTS = {declaration.name: declaration.default for declaration in RENDERER}
WORDS = {'outline': 'outlines', IMAGE.name: 'images', 'shadows': 'shadows',
         'sky.gradient': 'a sky'}
"""What the parameters are called that choose, if they are set."""


def kernels_of(values: Mapping) -> str:
    """Return in words what the kernels are compiled for."""
    words = [word for name, word in WORDS.items() if values[name]]
    return 'the rasterizer' + (f' with {" and ".join(words)}' if words else '')


def warm_up(values: Mapping) -> None:
    """Compile or load the kernels before the first frame that needs them."""
    values = {**DEFAULTS, **values}
    square = np.array([[[0.0, 0.0, 9.0], [1.0, 0.0, 9.0]], [[0.0, 0.0, 8.0], [1.0, 0.0, 8.0]]])
    # Whatever is in the image's file, and by day, for at night there are no shadows.
    image = Texture(np.zeros((1, 1, 3), np.uint8)) if values[IMAGE.name] else None
    look = look_of({**values, IMAGE.name: IMAGE.default})
    materials = dataclasses.replace(look.materials, flag_image=image)
    Picture().draw(square, None, *look._replace(materials=materials, light=Light()))


PICTURE_KERNELS = KernelChoice(tuple(WORDS), kernels_of, warm_up)
