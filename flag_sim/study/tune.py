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

"""Find the cheapest settings that keep within an error in pixels, and write a params file."""
import argparse
import datetime
import hashlib
import shutil
import sys

from flag_sim.parameters.arguments import given_path, positive
from flag_sim.study import machine, settings_file
from flag_sim.study.measures import summary
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.measures.settings import changed, defaults, RANGES
from flag_sim.study.runner import load_of_others, session
from flag_sim.study.search import MAX_LOAD, require, Search
from flag_sim.study.store import Store


def main(args: list[str] | None = None) -> int:
    """Tune; return 0, or 1 if the budget cannot be met on this machine."""
    parser = argparse.ArgumentParser(prog='tune', description=__doc__)
    parser.add_argument('--error-px', type=positive, required=True,
                        help=f'RMS error after {1e3 * WINDOW:.0f} ms that is allowed [pixel]')
    parser.add_argument('--rate', type=positive, default=30.0, help='frames a second [Hz] (30)')
    parser.add_argument('--output', type=given_path, required=True, help='the new params file')
    parser.add_argument('--params-file', type=given_path,
                        help='params file with your camera, image size, flag and wind')
    options = parser.parse_args(args)
    try:
        output = settings_file.check_new(options.output)
        settings, others = settings_file.read(options.params_file) if options.params_file else (
            defaults(), [])
        if others:
            print(f'not looked at: {", ".join(others)}', file=sys.stderr)
        if options.rate > RANGES['rate'][1]:
            raise ValueError(f'rate must be at most {RANGES["rate"][1]:g} Hz, not '
                             f'{options.rate:g}')
        require({**settings, 'rate': options.rate})
        work = output.with_name(f'{output.name}.unfinished')
        asked = hashlib.sha256(repr(sorted(settings.items())).encode()).hexdigest()
        store = Store(work, {**machine.identity(), 'rate': options.rate,
                             'settings': asked[:16]})
        try:
            with session(store):
                search = Search(settings, options.rate, store)
                choice, errors = search.find(options.error_px)
        except ValueError:
            # The flag may leave the picture in the wind only: there is nothing to go on with.
            shutil.rmtree(work)
            raise
        chosen = search.chosen(choice.option.name)
        values = settings_file.by_node(changed(settings, chosen), chosen)
        comment = _comment(options, search, choice, errors, list(values))
        settings_file.write(output, comment, values, work)
    except (ValueError, FileExistsError) as problem:
        parser.error(str(problem))
    except KeyboardInterrupt:
        print(f'\ninterrupted; the same command goes on from {work}', file=sys.stderr)
        return 130
    shutil.rmtree(work)
    print(output.read_text(), end='')
    return 0 if choice.is_accurate and choice.is_fast else 1


def _comment(options, search, choice, errors, nodes):
    """Return the lines of the params file's comment: what it promises, and what it misses."""
    settings, option, allowed_px = search.settings, choice.option, options.error_px
    others, frame_ms = load_of_others(search.store), 1e3 / options.rate
    others = '' if others is None else f' (others took {others:.1f} of them)'
    given = f' --params-file {options.params_file.name}' if options.params_file else ''
    lines = [
        f'Made by `tune --error-px {allowed_px:g} --rate {options.rate:g}{given}`',
        f'on {datetime.date.today()}, on {machine.processor()}, {machine.cores()} cores{others},',
        f'for a picture of {settings["width"]} x {settings["height"]} pixels and a camera at '
        f'{settings["camera.distance"]:g} m.',
        f'Give it to {", ".join(nodes[:-1])} and {nodes[-1]}, after your own params file.',
        '',
        f'Error: {summary.rms(errors):.2g} px (RMS) after {1e3 * search.window_s:.0f} ms, in '
        f'{len(errors)} windows of a shot that it',
        f'was not tuned on, in wind of {settings["speed"]:g} m/s with gusts of '
        f'{settings["gust.intensity"]:g}; {allowed_px:g} px are allowed'
        + ('.' if choice.is_accurate else ':'),
        *([] if choice.is_accurate else [
            f'MISSED: other shots may reach {option.error_px:.2g} px, '
            f'{option.error_px - allowed_px:.2g} px too much;',
            'nothing that was tried is better at this rate.']),
        f'Cost: {option.cost_ms:.2g} ms a frame for physics and drawing, one after the other, '
        'without messages;',
        f'{100.0 * option.cost_ms / frame_ms:.2g} % of the {frame_ms:.3g} ms at '
        f'{options.rate:g} Hz; {100.0 * MAX_LOAD:.0f} % are allowed, the rest is for messages '
        'and slow moments' + ('.' if choice.is_fast else (
            f': MISSED by {option.cost_ms - search.limit_ms:.2g} ms; nothing that was tried is '
            'faster.')),
    ]
    if search.chosen(option.name)['damping'] != settings['damping']:
        lines.append('damping is a ratio for one spring: it is scaled with the grid, so that the '
                     'sheet stays the same.')
    return lines


if __name__ == '__main__':
    sys.exit(main())
