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
The picture: scene, camera, light and the rasterizer.

In a few lines, with vertices (rows, columns, 3) [m] from anywhere:

>>> from flag_sim.drawing import Camera, Light, Picture
>>> frame = Picture().draw(vertices, camera=Camera(width=1280, height=720), light=Light())
>>> frame.colour                        # (720, 1280, 3) uint8
"""
from flag_sim.drawing.attributes import interpolate, Visibility
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.framebuffer import Frame
from flag_sim.drawing.picture import Picture
from flag_sim.drawing.scene import body, flag_scene, Object, sheet
from flag_sim.drawing.shading import Light, Surface
from flag_sim.drawing.shapes import Scene
from flag_sim.drawing.style import Materials, Style

__all__ = ['body', 'Camera', 'flag_scene', 'Frame', 'interpolate', 'Light', 'Materials', 'Object',
           'Picture', 'Scene', 'sheet', 'Style', 'Surface', 'Visibility']
