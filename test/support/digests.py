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

"""Prints a digest of each solver's motion and each kind of picture, as compiled here."""
import hashlib

from flag_sim.cloth import Cloth
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.drawing import (
    Camera, Dimensions, flag_scene, LastFrame, Materials, Picture, Style, Texture)
import numpy as np

POLE = (0.0, 0.0, 0.05)
CAMERA = Camera(320, 240)
STYLES = {'screen': Style(), 'perspective': Style(interpolation='perspective'),
          'flat': Style(shading='flat'), 'samples': Style(samples=8),
          'painter': Style(hidden_surface='painter'), 'outline': Style(outline=True),
          'looks': Style(shadows=True, sky_gradient=True, samples=4)}
CHANNELS = ('depth', 'normals', 'labels', 'texture_coordinates', 'flow')


def blown(frames, **options):
    """Return a cloth that has been in gusts, and where it was a frame before."""
    cloth = Cloth(pole=POLE, **options)
    for frame in range(frames):
        before = cloth.positions.copy()
        cloth.advance(1.0 / 30.0, wind=(9.0 + frame % 7, 3.0, 0.5))
    return cloth, before


def tell(name, *arrays):
    """Print a name and the digest of some arrays."""
    data = b''.join(np.ascontiguousarray(array).tobytes() for array in arrays)
    print(name, hashlib.sha256(data).hexdigest(), sep='\t')


if __name__ == '__main__':
    for solver in SOLVERS:
        for precision in ('float64', 'float32'):
            cloth, _ = blown(20, rows=9, columns=13, solver=solver, precision=precision)
            tell(f'{solver}, {precision}', cloth.positions, cloth.velocities)
    cloth, before = blown(30)
    image = Texture(np.indices((37, 50, 3)).prod(axis=0).astype(np.uint8))
    for name, style in STYLES.items():
        objects = flag_scene(
            cloth.positions, cloth.normals(), CAMERA, last=LastFrame(before, CAMERA),
            materials=Materials(flag_image=image if name == 'looks' else None),
            dimensions=Dimensions(ground_visible=name == 'looks'))
        frame = Picture().draw_scene(objects, CAMERA, style=style, channels=CHANNELS)
        tell(name, frame.colour, *(getattr(frame, channel) for channel in CHANNELS))
