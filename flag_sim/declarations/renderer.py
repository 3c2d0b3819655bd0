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

"""Parameters of the renderer node."""
from flag_sim.declarations.objects import OBJECTS
from flag_sim.declarations.scene import (
    DIMENSIONS, PLACE_FIELDS, PLATFORM_FIELDS, POLE_FIELDS, SCENE)
from flag_sim.drawing import Camera, Light, Materials, Style
from flag_sim.drawing.style import THREADS
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.declared import Group

CAMERA = Group(Camera(), 'camera.')
LIGHT = Group(Light(), 'sun.')
STYLE = Group(Style())
# Only the flag is thin enough to let light through.
SURFACES = {
    'flag': Group(Materials().flag, 'flag.', thing='flag'),
    'pole': Group(Materials().pole, 'pole.', exclude=('transmission',), thing='pole'),
    'platform': Group(Materials().platform, 'platform.', exclude=('transmission',),
                      thing='platform'),
    'ground': Group(Materials().ground, 'ground.', thing='ground',
                    exclude=('transmission', 'specular', 'shininess')),
}
FRAME_ID = Declaration('camera.frame_id', 'camera_optical_frame',
                       "name of the camera's optical frame in headers", fixed=True)
IMAGE = Declaration(
    'flag.image', '', 'file of a picture on the flag, or one of tricolour.png, cross.png and '
    'checker.png; empty: flag.color')
COMPRESSED = (
    Declaration('compressed.format', 'jpeg', 'of camera/image_raw/compressed',
                choices=('jpeg', 'png')),
    Declaration('compressed.jpeg_quality', 95, 'more is nearer to the picture, and larger', '',
                1, 100),
)

RENDERER = (
    *SCENE,
    *CAMERA,
    FRAME_ID,
    *STYLE.without('background', 'sky_gradient', 'sky_zenith'),
    *LIGHT,
    *SURFACES['flag'],
    IMAGE,
    *SURFACES['pole'],
    *SURFACES['platform'],
    *SURFACES['ground'],
    *DIMENSIONS.without(*POLE_FIELDS, *PLACE_FIELDS, *PLATFORM_FIELDS),
    *OBJECTS,
    *STYLE.pick('background', 'sky_gradient', 'sky_zenith'),
    *COMPRESSED,
    THREADS,
)
