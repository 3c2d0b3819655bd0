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
Whether what tune promises holds: near, default and far cameras, two budgets, shots of ten seeds.

Prints for each camera and budget what tune takes, its cost, and the error in shots that it was
neither tuned nor checked on. Takes some five minutes on a quiet machine; --folder keeps the
references, so that a second run takes one.
"""
import argparse
from pathlib import Path
import tempfile

from flag_sim.parameters.arguments import given_path
from flag_sim.study import machine
from flag_sim.study.measures.reference import FINEST, Reference
from flag_sim.study.measures.settings import changed, defaults
from flag_sim.study.measures.summary import rms
from flag_sim.study.measures.trials import Trials
from flag_sim.study.search import Search
from flag_sim.study.store import Store

CAMERAS = {'near': 2.8, 'default': 5.5, 'far': 22.0}  # distances [m]
SEEDS = range(2001, 2011)  # tune itself takes 0 and 1000
WINDOWS = 4


def errors_of(search, name, folder):
    """Return the RMS error [px] of a candidate in the shot of each seed."""
    found = []
    for seed in SEEDS:
        shot = changed(search.settings, {'gust.seed': seed})
        # The camera has no part in a reference: all cameras share its windows.
        trials = Trials(Reference(shot, 1, folder / f'seed{seed}', FINEST), shot)
        rows = [trials.motion(search.candidates[name], trials.reference.window(number))[0]
                for number in range(WINDOWS)]
        found.append(rms([row['rms_px'] for row in rows]))
    return found


def main():
    """Tune for every camera and budget, and try what comes of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--error-px', type=float, nargs='+', default=[4.0, 8.0])
    parser.add_argument('--folder', type=given_path, default=None, help='keeps the references')
    options = parser.parse_args()
    folder = options.folder or Path(tempfile.mkdtemp(prefix='flag_sim-tuning-'))
    folder.mkdir(exist_ok=True)
    for camera, distance in CAMERAS.items():
        own = Store(folder / camera, machine.identity())
        for part in ('tune', 'check'):
            (folder / part).mkdir(exist_ok=True)
            if not (own.folder / part).exists():
                (own.folder / part).symlink_to(folder.resolve() / part)
        search = Search(defaults(camera__distance=distance), 30.0, own)
        for budget in options.error_px:
            choice, _ = search.find(budget)
            found = errors_of(search, choice.option.name, folder)
            print(f'{camera:8} {budget:4g} px: {choice.option.name:20} '
                  f'{choice.option.cost_ms:6.2f} ms, '
                  f'{"promised" if choice.is_accurate else "missed"}, within the budget in '
                  f'{sum(one <= budget for one in found)} of {len(found)} shots: '
                  + ' '.join(f'{one:.2f}' for one in found), flush=True)


if __name__ == '__main__':
    main()
