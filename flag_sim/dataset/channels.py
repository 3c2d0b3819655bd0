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

"""Channels: what a clip can hold of each frame, and the arrays in which it does."""
from collections.abc import Callable, Iterable, Mapping
import functools
from typing import NamedTuple

from flag_sim.cloth.self_intersection import is_self_intersecting
from flag_sim.drawing import Frame
from flag_sim.drawing.motion import hidden, Motion, motion
from flag_sim.drawing.scene import FLAG, flag_scene
import numpy as np


class View:
    """
    A frame, of which a channel is made only if it is asked for.

    moment, before, after: Moments of the frame and of its neighbours, None where there are none;
    frame: what was drawn of it, with the channel `visibility`, or None.
    """

    def __init__(self, moment, before, after, frame: Frame | None):
        self.moment = moment
        self.before = before
        self.after = after
        self.frame = frame

    @functools.cached_property
    def was_hidden(self) -> np.ndarray:
        """Return whether what is seen was hidden in the frame before, (height, width) bool."""
        if self.before is None:
            return np.zeros(self.frame.labels.shape, np.bool_)
        return hidden(*self._with(self.before))

    @functools.cached_property
    def forward(self) -> Motion:
        """Return where what is seen will be in the next frame, and whether it is hidden there."""
        if self.after is None:
            shape = self.frame.labels.shape
            return Motion(np.full((*shape, 2), np.nan, np.float32), np.zeros(shape, np.bool_))
        return motion(*self._with(self.after))

    def _with(self, other):
        """Return what tells of the motion between this frame and another one."""
        return (self.frame.visibility, scene_of(self.moment, other), self.moment.look.camera,
                other.look.camera)

    @property
    def flag_pixels(self) -> int:
        """Return how many pixels show the flag."""
        return int(np.count_nonzero(self.frame.labels == FLAG))


def scene_of(moment, other) -> list:
    """Return the objects of a Moment; `before` is where they are in the other one, if any."""
    return flag_scene(moment.positions, moment.normals, moment.look.camera, moment.look.materials,
                      moment.look.dimensions, other.as_last() if other is not None else None)


class Channel(NamedTuple):
    """
    One thing to know of a frame.

    what: in words. needs: channels of the picture, see drawing.Picture.draw_scene; None: no
    picture. arrays: {name of the array: function of a View that returns its part of a frame}.
    """

    what: str
    needs: tuple | None
    arrays: Mapping[str, Callable[[View], np.ndarray]]


def _image(name, what, array=''):
    """Return the channel of one of the picture's own."""
    needs = () if name == 'colour' else (name,)
    return Channel(what, needs, {array or name: lambda view: getattr(view.frame, name)})


def _pose(view):
    return view.moment.look.camera.pose


CHANNELS = {
    'colour': _image('colour', 'red, green and blue, (height, width, 3) uint8'),
    'depth': _image('depth', 'along the optical axis [m], inf where nothing is, float32'),
    'normals': _image('normals', 'unit normals in the optical frame, of the side that is seen, '
                      '(height, width, 3) float32; 0 where nothing is'),
    'labels': _image('labels', '0 nothing, 1 flag, 2 pole, 3 platform, 4 ground, boxes from 5 '
                     'on, uint8'),
    'texture_coordinates': _image('texture_coordinates', '(u, v) on the flag, nan elsewhere, '
                                  '(height, width, 2) float32'),
    'backward_flow': Channel(
        'where the point of the surface was in the frame before, minus where it is [pixel], '
        '(height, width, 2) float32, nan where nothing is; and whether it was hidden there, bool',
        ('flow', 'visibility'), {
            'backward_flow': lambda view: view.frame.flow,
            'backward_occlusion': lambda view: view.was_hidden}),
    'forward_flow': Channel(
        'where it will be in the next frame, minus where it is; and whether it is hidden there',
        ('visibility',), {
            'forward_flow': lambda view: view.forward.flow,
            'forward_occlusion': lambda view: view.forward.is_hidden}),
    'vertices': Channel(
        'of the flag in the world [m], (rows, columns, 3) float32', None,
        {'vertices': lambda view: view.moment.points[..., :3]}),
    'velocities': Channel(
        'of the vertices [m/s], (rows, columns, 3) float32', None,
        {'velocities': lambda view: view.moment.velocities}),
    'wind': Channel('(3,) float64 [m/s]', None, {'wind': lambda view: view.moment.wind}),
    'camera': Channel(
        'its pose, (4, 4) from the world to the optical frame, and its projection, (3, 4) from '
        'there to pixels, as P of CameraInfo, float64', None, {
            'camera_pose': _pose,
            'camera_projection': lambda view: view.moment.look.camera.P}),
    'pole_load': Channel(
        'what the flag does to its pole: force [N] and moment [N m] about the upper hoist corner, '
        '(6,) float64', None, {'pole_load': lambda view: view.moment.pole_load}),
    'self_intersecting': Channel(
        'whether the cloth passes through itself, bool', None, {
            'self_intersecting': lambda view: np.bool_(
                is_self_intersecting(view.moment.points[..., :3]))}),
}


def expanded(names: Iterable[str]) -> tuple[str, ...]:
    """Return names of CHANNELS in its order."""
    return tuple(name for name in CHANNELS if name in set(names))


def picture_channels(names: Iterable[str]) -> set[str] | None:
    """Return what the picture must hold for some of CHANNELS; None: it need not be drawn."""
    needs = [CHANNELS[name].needs for name in names if CHANNELS[name].needs is not None]
    # By its labels it is known whether the camera sees the flag.
    return {'labels', *(one for some in needs for one in some)} if needs else None


def arrays_of(view: View, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Return {array: its part of a frame} of some of CHANNELS, and the frame's time [s]."""
    return {'time': np.float64(view.moment.stamp / 1e9),
            **{array: np.asarray(make(view)) for name in names
               for array, make in CHANNELS[name].arrays.items()}}
