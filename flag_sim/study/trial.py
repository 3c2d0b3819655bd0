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
from flag_sim.study import error
from flag_sim.study.settings import changed, look_of, picture_of

BEST = {'samples': 16, 'interpolation': 'perspective', 'hidden_surface': 'zbuffer',
        'shading': 'gouraud', 'outline': False, 'drawing.threads': 1}
"""How the reference picture is drawn."""
MILLI = 1e3


class Trials:
    """
    Compares settings with a Reference, as the camera of `base` settings sees both.

    Compiles what it meets for the first time before it measures.
    """

    def __init__(self, reference, base):
        self.reference = reference
        self.base = base
        self.camera = look_of(base).camera
        self._warm = set()
        self._drawn = {}

    def motion(self, settings, window, frames=1):
        """
        Run settings through the first frames of a window; return a row of numbers.

        rms_mm, worst_mm, rms_px, worst_px: at all nodes of the finest grid; None if it diverged.
        physics_ms: the median frame. stiffness: what the steps left of it.
        """
        row, _ = self._run(settings, window, frames)
        return row

    def whole(self, settings, window, frames=1):
        """
        Return the row of motion, and what the picture at the window's end is like.

        drawing_ms: the median of three; psnr_db, ssim: against the reference's picture;
        drawing_psnr_db, drawing_ssim: of the reference's own vertices, so of the drawing alone.
        """
        row, positions = self._run(settings, window, frames)
        row |= dict.fromkeys(('drawing_ms', 'psnr_db', 'ssim', 'drawing_psnr_db',
                              'drawing_ssim'))
        if positions is None:
            return row
        picture, look = picture_of(settings), look_of(settings)
        self._warm_up(settings, lambda: picture.draw(positions, None, *look))
        times = []
        for _ in range(3):
            begin = time.perf_counter()
            image = picture.draw(positions, None, *look)
            times.append(MILLI * (time.perf_counter() - begin))
        row['drawing_ms'] = sorted(times)[1]
        right = self._right(window, frames)
        row['psnr_db'], row['ssim'] = _likeness(image, right)
        still = picture.draw(window.ends[frames - 1], None, *look)
        row['drawing_psnr_db'], row['drawing_ssim'] = _likeness(still, right)
        return row

    def _run(self, settings, window, frames):
        shot = self.reference.shot
        cloth = self.reference.start(window, settings)
        self._warm_up((settings['solver'], settings.get('precision')),
                      lambda: cloth.advance(1e-6))
        cloth = self.reference.start(window, settings)
        times = []
        try:
            for frame in range(window.frame + 1, window.frame + frames + 1):
                begin = time.perf_counter()
                plan = cloth.advance(shot.dt, shot.wind(frame))
                normals = cloth.normals()
                times.append(MILLI * (time.perf_counter() - begin))
        except Diverged:
            return dict.fromkeys(('rms_mm', 'worst_mm', 'rms_px', 'worst_px', 'physics_ms',
                                  'substeps', 'stiffness')), None
        del normals
        positions, right = self.reference.filled(cloth.positions), window.ends[frames - 1]
        metres = error.distances(positions, right)
        pixels = error.pixel_distances(positions, right, self.camera)
        return {'rms_mm': MILLI * error.rms(metres), 'worst_mm': MILLI * float(metres.max()),
                'rms_px': error.rms(pixels), 'worst_px': float(pixels.max()),
                'physics_ms': sorted(times)[len(times) // 2], 'substeps': plan.granted,
                'stiffness': plan.stiffness_factor}, cloth.positions

    def _right(self, window, frames):
        """Return the reference's picture."""
        key = window.frame, frames
        if key not in self._drawn:
            best = changed(self.base, BEST)
            self._drawn[key] = picture_of(best).draw(
                window.ends[frames - 1], None, *look_of(best)).copy()
        return self._drawn[key]

    def _warm_up(self, kind, run):
        """Run once before anything of this kind is measured."""
        kind = str(kind)
        if kind not in self._warm:
            self._warm.add(kind)
            run()


def _likeness(image, right):
    """Return PSNR [dB], at most 99, and SSIM of a picture shown in the size of the right one."""
    shown = error.resized(image, *right.shape[:2])
    return min(error.psnr(shown, right), 99.0), error.ssim(shown, right)
