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

The modules, in the order in which a frame passes them:

- picture: the frame from end to end; it calls all the others
- scene: a list of objects, and the entries of the source's scene: flag, pole, platform
- dimensions: how large things are and where they stand
- mesh, shapes: triangles and their normals; the pole, the platform, a box
- camera, transforms: where the camera stands and what it sees; affine maps
- style: what things are made of, and how the picture is made
- scene_buffers: the objects joined in arrays, and which of them have changed
- geometry: vertices taken to the screen
- shading: light on vertices
- shaded_scene: what pixels are shaded with that are shaded one by one
- culling: which triangles can be seen, and in which rows
- painter: triangles from far to near, where that is asked for
- bands: what a thread draws at a time, from clearing to bytes
- rasterizer: triangles in, pixels out; it chooses between the next two
- triangle_setup, batched: SMALL and MEDIUM triangles, many at a time
- polygon, clipping, scanline: LARGE and clipped triangles, one by one
- coverage: the fill rule (top-left)
- depth: reversed Z and the depth test
- pixels: vectors of pixels, packed colours
- outline: the triangles' edges as lines
- multisample: several samples a pixel, where there are edges
- visibility: which triangle each pixel sees
- surfaces, pixel_pass: pixels that are shaded one by one, with the next three
- texture, shadows, sky: pictures on surfaces; the scene as the sun sees it; what is behind it
- image_file: a texture from a file
- framebuffer: the frame, and its images that are kept
- channels: normals, labels, texture coordinates and flow of what each pixel sees
- motion: where what each pixel sees is in another frame, and whether it is hidden there
- attributes: any values, interpolated to the pixels of a frame
- ranges: checks of what is passed in
- plain: one triangle in plain numpy, to be read first
"""
from flag_sim.drawing import transforms
from flag_sim.drawing.attributes import interpolate
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.dimensions import Box, Dimensions
from flag_sim.drawing.framebuffer import Frame
from flag_sim.drawing.mesh import Mesh
from flag_sim.drawing.picture import Picture
from flag_sim.drawing.scene import body, flag_scene, LastFrame, Object, sheet
from flag_sim.drawing.shading import Light, Surface
from flag_sim.drawing.shapes import box_mesh
from flag_sim.drawing.style import Materials, Style
from flag_sim.drawing.texture import Texture
from flag_sim.drawing.visibility import Visibility

__all__ = ['body', 'Box', 'box_mesh', 'Camera', 'Dimensions', 'flag_scene', 'Frame',
           'interpolate', 'LastFrame', 'Light', 'Materials', 'Mesh', 'Object', 'Picture', 'sheet',
           'Style', 'Surface', 'Texture', 'transforms', 'Visibility']
