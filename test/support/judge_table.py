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

"""A judge of settings for tests, which takes what it says of them from a table."""
from flag_sim.study.measures.judge import Judge


class Table:
    """
    A judge of settings that measures nothing: what it says of them is made up.

    A frame costs cost_ms times the columns; the error is error_px over the columns, in all shots
    but the first times `refuted`, by columns. restless, odd: columns of grids that do not rest, or
    behave. own_px: error of the reference itself.
    """

    cost_ms, error_px = 0.1, 100.0
    refuted, restless, odd, parted, own_px = {}, (), (), 0.4, 0.0

    def __init__(self, monkeypatch):
        self.seen = []
        for name in ('follow', 'convergence', 'behave', 'rest', 'drawing_ms', 'horizon'):
            monkeypatch.setattr(Judge, name, self._bound(getattr(self, name)))

    @staticmethod
    def _bound(method):
        return lambda judge, *arguments: method(*arguments)

    def follow(self, settings, window, gusts):
        """Return the error and the time of a grid; single precision is cheaper."""
        columns = settings['grid.columns']
        self.seen.append((columns, settings['solver'], settings['substeps'],
                          settings['precision'], window, gusts))
        error = self.error_px / columns * (self.refuted.get(columns, 1.0) if gusts else 1.0)
        slower = 1.0 if settings['precision'] == 'float32' else 1.2
        return {'px_0.2': error, 'physics_ms': self.cost_ms * columns * slower}

    def convergence(self, window, gusts):
        """Return how far grids are from the reference: it converges, by 4 a halving."""
        del window, gusts
        return {'px_0.2': 2.4 * self.own_px}, {'px_0.2': 9.6 * self.own_px}, {}

    def behave(self, settings):
        """Return how a grid behaves."""
        return {'behaves': 1e3 if settings['grid.columns'] in self.odd else 1.0}

    def rest(self, settings):
        """Return how a grid rests."""
        return {'rests': 1e9 if settings['grid.columns'] in self.restless else 0.1, 'sag_mm': 2.0}

    def drawing_ms(self, settings):
        """Return what the picture costs."""
        del settings
        return 0.5

    def horizon(self):
        """Return when two runs part."""
        return self.parted
