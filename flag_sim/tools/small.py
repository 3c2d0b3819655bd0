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

"""Pictures made small for sheets and films, whatever their proportions."""
import numpy as np
from PIL import Image

HIGHEST = 2
"""Height of a small picture, by the width that it may have."""


def small(rgb: np.ndarray, width: int) -> Image.Image:
    """Return a picture as an image that is so wide or, if it is slim, HIGHEST times as high."""
    image = Image.fromarray(rgb)
    scale = min(width / image.width, HIGHEST * width / image.height)
    size = [max(1, round(side * scale)) for side in image.size]
    return image.resize(size, Image.Resampling.LANCZOS)
