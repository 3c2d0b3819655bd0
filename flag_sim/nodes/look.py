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

"""From the renderer's dials to what the picture is drawn with."""
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.light import Light, Material
from flag_sim.drawing.scene import Scene
from flag_sim.drawing.style import Materials, Style


class Look(NamedTuple):
    """Everything that a frame's picture depends on, but the cloth."""

    camera: Camera
    light: Light
    materials: Materials
    scene: Scene
    style: Style


def look_of(values):
    """Return the Look of the renderer's values {dial: value}, or raise ValueError."""
    def group(prefix, *names):
        return {name: values[f'{prefix}.{name}'] for name in names}

    return Look(
        Camera(values['width'], values['height'],
               **group('camera', 'projection', 'vertical_fov', 'scale', 'target', 'distance',
                       'azimuth', 'elevation', 'roll', 'near')),
        Light(**group('sun', 'azimuth', 'elevation', 'intensity'), ambient=values['ambient']),
        Materials(
            Material(**group('flag', 'color', 'diffuse', 'specular', 'shininess', 'transmission')),
            *(Material(**group(thing, 'color', 'diffuse', 'specular', 'shininess'))
              for thing in ('pole', 'platform'))),
        Scene(values['pole.height'], values['pole.diameter'],
              values['platform.side'], values['platform.height'],
              values['pole.visible'], values['platform.visible']),
        Style(**{name: values[name] for name in (
            'background', 'shading', 'interpolation', 'samples', 'hidden_surface', 'outline')}))
