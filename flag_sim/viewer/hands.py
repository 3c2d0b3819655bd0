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

"""Hands on the picture, made into parameters of the renderer."""
from flag_sim.viewer import camera_moves
from flag_sim.viewer.graph_model import GraphModel
from flag_sim.viewer.picture_view import PictureView
from qtpy.QtCore import QObject, Signal


class Hands(QObject):
    """
    Turns, shifts and scales the view by what `view` tells.

    Each move counts from the values that were asked for last, so that none is lost while the
    renderer has not answered. said: why nothing moves, in words.
    """

    said = Signal(str)

    def __init__(self, view: PictureView, model: GraphModel):
        super().__init__(view)
        self._model = model
        view.wheel.connect(lambda steps: self._move(camera_moves.zoom(self._read, steps)))
        view.dragged.connect(lambda *way: self._move(camera_moves.turn(self._read, *way)))
        view.keyed.connect(lambda right, up: self._move(camera_moves.shift(
            self._read, camera_moves.SHIFT * right, camera_moves.SHIFT * up)))
        view.double_clicked.connect(self._reset)

    def _read(self, name):
        return self._model.wanted('renderer', name)

    def _reset(self):
        first = {name: self._model.first_value('renderer', name) for name in camera_moves.MOVED}
        self._move({name: value for name, value in first.items()
                    if value not in (None, self._read(name))})

    def _move(self, changes):
        if not changes:
            return
        keyed = [name for name in changes if self._model.keyed('renderer', name)]
        if keyed and not self._model.value('wind', 'autokey'):
            self.said.emit(f'{", ".join(keyed)}: a track plays it, whatever is set here')
        self._model.put('renderer', changes)
