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

"""Measure what accuracy costs on this machine, and write a report with plots and tables."""
import argparse
import hashlib
from pathlib import Path
import sys

from flag_sim.parameters.arguments import given_path, positive
from flag_sim.study import machine, report, runner, settings_file
from flag_sim.study.measures.settings import defaults
from flag_sim.study.sections import all_sections
from flag_sim.study.sections.real import Real, TITLE
from flag_sim.study.store import Store

FORMAT = 6  # of the rows: raised when their columns or their meaning change
FOLDERS = Path('out/study'), Path('out/real')
"""Where the study of accuracy, and that of real flags, is written by default."""
DEFAULT_FLAG = True
"""Stands for the params file where none is given: no path equals it."""
UNSPOKEN = {**machine.UNSPOKEN, 'format': 'its rows are those of another version of study',
            'flag': 'it is of another flag'}
"""What a difference of a study's identity means, in words (see Store)."""


def main(args: list[str] | None = None) -> int:
    """Run the study; return the exit status."""
    parser = argparse.ArgumentParser(prog='study', description=__doc__)
    parser.add_argument('--minutes', type=positive, default=5.0, help='time to measure [min] (5)')
    parser.add_argument('--output', type=given_path,
                        help='folder of what is made (out/study, or out/real); one that was '
                        'interrupted is continued')
    parser.add_argument('--real', nargs='?', type=given_path, const=DEFAULT_FLAG, metavar='PARAMS',
                        help='instead compare with real flags: the default one, or that of a '
                        'params file')
    options = parser.parse_args(args)
    is_real = options.real is not None
    try:
        identity = {'format': FORMAT, **machine.identity()}
        if is_real:
            settings = _settings(options.real)
            sections = [Real(settings)]
            known = hashlib.sha256(repr(sorted(settings.items())).encode()).hexdigest()
            identity['flag'] = known[:16]
        else:
            sections = all_sections()
        store = Store(options.output or FOLDERS[is_real], identity, UNSPOKEN)
    except ValueError as error:
        parser.error(str(error))
    try:
        with runner.session(store):
            for section, budget in runner.share(60.0 * options.minutes, sections):
                runner.measure(section, store, budget)
    except KeyboardInterrupt:
        print('\ninterrupted; the same command goes on from here', file=sys.stderr)
        return 130
    if is_real:
        print(sections[0].tests(store), end='\n\n')
    print(report.write(store, sections, options.minutes, *[TITLE] * is_real))
    return 0


def _settings(path):
    """Return the settings of a params file; say which of its parameters the flag does not have."""
    if path == DEFAULT_FLAG:
        return defaults()
    settings, others = settings_file.read(path)
    if others:
        print(f'not looked at: {", ".join(others)}', file=sys.stderr)
    return settings


if __name__ == '__main__':
    sys.exit(main())
