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

"""A trial: settings that run through a window, timed, and compared with the reference."""
import time

from flag_sim.cloth import Diverged
from flag_sim.dials.settings import look_of
from flag_sim.study import error
from flag_sim.study.settings import changed, picture_of

BEST = {'samples': 16, 'interpolation': 'perspective', 'hidden_surface': 'zbuffer',
        'shading': 'gouraud', 'outline': False, 'drawing.threads': 1}
"""How the reference picture is drawn."""
MILLI = 1e3
TIMED = 3
"""Frames whose median time counts."""
MOST_DB = 99.0
"""Of pictures that are equal, whose PSNR is infinite."""


class Trials:
    """
    Compares settings with a Reference, as the camera of `base` settings sees both.

    frames: after how many frames of a window.

    Compiles what it meets for the first time before it measures.
    """

    def __init__(self, reference, base, frames=1):
        self.reference = reference
        self.base = base
        self.frames = frames
        self.camera = look_of(base).camera
        self._warm = set()
        self._drawn = {}

    def motion(self, settings, window):
        """
        Run settings through a window; return a row of numbers and where it ended.

        rms_mm, worst_mm, rms_px, worst_px: at all nodes of the finest grid. physics_ms: the
        median of TIMED frames after the window, when what it needs is in the caches. stiffness:
        what the steps left of it. If the run diverged all are None, and so are the positions.
        """
        shot, right = self.reference.shot, self._end(window)
        self._warm_up((settings['solver'], settings['precision']),
                      lambda: self.reference.start(window, settings).advance(1e-6))
        cloth = self.reference.start(window, settings)
        times, positions = [], None
        try:
            while len(times) < self.frames + TIMED:
                begin = time.perf_counter()
                plan = cloth.advance(shot.dt, shot.wind(window.frame + len(times) + 1))
                cloth.normals()
                times.append(MILLI * (time.perf_counter() - begin))
                if len(times) == self.frames:
                    positions = cloth.positions
        except Diverged:
            return dict.fromkeys(('rms_mm', 'worst_mm', 'rms_px', 'worst_px', 'physics_ms',
                                  'substeps', 'stiffness')), None
        filled = self.reference.filled(positions)
        metres = error.distances(filled, right)
        pixels = error.pixel_distances(filled, right, self.camera)
        return {'rms_mm': MILLI * error.rms(metres), 'worst_mm': MILLI * float(metres.max()),
                'rms_px': error.rms(pixels), 'worst_px': float(pixels.max()),
                'physics_ms': sorted(times[self.frames:])[TIMED // 2], 'substeps': plan.granted,
                'stiffness': plan.stiffness_factor}, positions

    def picture(self, settings, positions, window, with_ssim=True):
        """
        Draw the positions that settings came to; return a row of numbers, None where none.

        drawing_ms: the median of TIMED; psnr_db, ssim: against the reference's picture.
        """
        row = dict.fromkeys(('drawing_ms', 'psnr_db', 'ssim')[:3 if with_ssim else 2])
        if positions is None:
            return row
        picture, look = picture_of(settings), look_of(settings)
        picture.draw(positions, None, *look)
        times = []
        for _ in range(TIMED):
            begin = time.perf_counter()
            frame = picture.draw(positions, None, *look)
            times.append(MILLI * (time.perf_counter() - begin))
        right = self._right(window)
        image = error.resized(frame.colour, *right.shape[:2])
        row['drawing_ms'] = sorted(times)[TIMED // 2]
        row['psnr_db'] = min(error.psnr(image, right), MOST_DB)
        if with_ssim:
            row['ssim'] = error.ssim(image, right)
        return row

    def still(self, settings, window):
        """Return what drawing the reference's own vertices by settings does to the picture."""
        right = self._right(window)
        image = picture_of(settings).draw(self._end(window), None, *look_of(settings)).colour
        image = error.resized(image, *right.shape[:2])
        return {'drawing_psnr_db': min(error.psnr(image, right), MOST_DB),
                'drawing_ssim': error.ssim(image, right)}

    def _end(self, window):
        """Return where the reference is at the end of a window: (rows, columns, 3) [m]."""
        return window.ends[self.frames - 1]

    def _right(self, window):
        """Return the reference's picture."""
        if window.frame not in self._drawn:
            best = changed(self.base, BEST)
            self._drawn[window.frame] = picture_of(best).draw(
                self._end(window), None, *look_of(best)).colour.copy()
        return self._drawn[window.frame]

    def _warm_up(self, kind, run):
        """Run once before anything of this kind is measured."""
        if kind not in self._warm:
            self._warm.add(kind)
            run()
