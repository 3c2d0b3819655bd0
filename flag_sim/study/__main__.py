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
from pathlib import Path
import sys

from flag_sim.parameters.arguments import given_path, positive
from flag_sim.study import machine, report, runner
from flag_sim.study.sections import all_sections
from flag_sim.study.store import Store

FORMAT = 6  # of the rows: raised when their columns or their meaning change


def main(args: list[str] | None = None) -> int:
    """Run the study; return the exit status."""
    parser = argparse.ArgumentParser(prog='study', description=__doc__)
    parser.add_argument('--minutes', type=positive, default=5.0, help='time to measure [min] (5)')
    parser.add_argument('--output', type=given_path, default=Path('out/study'),
                        help='folder of what is made (out/study); one that was interrupted is '
                        'continued')
    options = parser.parse_args(args)
    try:
        store = Store(options.output, {'format': FORMAT, **machine.identity()})
    except ValueError as error:
        parser.error(str(error))
    sections = all_sections()
    try:
        with runner.session(store):
            for section, budget in runner.share(60.0 * options.minutes, sections):
                runner.measure(section, store, budget)
    except KeyboardInterrupt:
        print('\ninterrupted; the same command goes on from here', file=sys.stderr)
        return 130
    print(report.write(store, sections, options.minutes))
    return 0


if __name__ == '__main__':
    sys.exit(main())
