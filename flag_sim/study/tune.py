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

"""Find the cheapest settings that keep within an error in pixels, behave and come to rest."""
import argparse
import datetime
import hashlib
import shutil
import sys

from flag_sim.parameters import checks
from flag_sim.parameters.arguments import given_path, positive
from flag_sim.study import machine, settings_file
from flag_sim.study.candidates import require
from flag_sim.study.measures import behaves, rests
from flag_sim.study.measures.judge import LENGTH
from flag_sim.study.measures.settings import changed, defaults, RANGES
from flag_sim.study.runner import load_of_others, print_progress, session
from flag_sim.study.search import Choice, MAX_LOAD, Search
from flag_sim.study.store import Store

LONGEST = 1.0  # time after which an error may be asked for: then all runs have parted [s]


def main(args: list[str] | None = None) -> int:
    """Tune; return 0, or 1 if what is asked cannot be kept on this machine."""
    parser = argparse.ArgumentParser(prog='tune', description=__doc__)
    parser.add_argument('--error-px', type=positive, required=True,
                        help='RMS error of the vertices that is allowed [pixel]')
    parser.add_argument('--seconds', type=positive, default=0.2,
                        help='for how long it is kept, from a common state [s] (0.2)')
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
        _require(options)
        require({**settings, 'rate': options.rate})
        work = output.with_name(f'{output.name}.unfinished')
        asked = hashlib.sha256(repr(sorted(settings.items())).encode()).hexdigest()
        store = Store(work, {**machine.identity(), 'rate': options.rate,
                             'seconds': options.seconds, 'settings': asked[:16]},
                      {**machine.UNSPOKEN, 'settings': 'it is for another params file'})
        try:
            with session(store):
                search = Search(settings, options.rate, options.seconds, store)
                print_progress(
                    f'about {max(1, round(search.minutes()))} min on an idle machine, longer '
                    'where many candidates are tried')
                choice = search.find(options.error_px)
        except ValueError:
            # The flag may leave the picture in the wind only: there is nothing to go on with.
            shutil.rmtree(work)
            raise
        chosen = search.chosen(choice.verdict.name)
        values = settings_file.by_node(changed(settings, chosen), chosen)
        comment = _comment(options, search, choice, settings, list(values))
        settings_file.write(output, comment, values, work)
    except (ValueError, FileExistsError) as problem:
        parser.error(str(problem))
    except KeyboardInterrupt:
        print(f'\ninterrupted; the same command goes on from {work}', file=sys.stderr)
        return 130
    shutil.rmtree(work)
    print(output.read_text(), end='')
    return 0 if choice.is_accurate and choice.is_sound and choice.is_fast else 1


def _require(options):
    """Raise ValueError for a rate or a time that cannot be."""
    if options.rate > RANGES['rate'][1]:
        raise ValueError(f'rate must be at most {RANGES["rate"][1]:g} Hz, not '
                         f'{checks.text(options.rate)}')
    if options.seconds > LONGEST:
        raise ValueError(f'seconds must be at most {LONGEST:g}, not '
                         f'{checks.text(options.seconds)}: after that no two runs are alike')


def _kept(is_kept: bool, missed: str) -> str:
    """Return the end of a line that promises something, or says that it is missed."""
    return '.' if is_kept else f': MISSED{missed}.'


def _comment(options, search: Search, choice: Choice, settings, nodes):
    """Return the lines of the params file's comment: what it promises, and what it misses."""
    verdict, shot, judge = choice.verdict, search.settings, search.judge
    frame_ms, horizon = 1e3 / options.rate, judge.horizon()
    given = f' --params-file {options.params_file.name}' if options.params_file else ''
    of_shots = verdict.of_shots
    lines = [
        f'Made by `tune --error-px {options.error_px:g} --seconds {options.seconds:g} '
        f'--rate {options.rate:g}{given}`',
        f'on {datetime.date.today()}, on {machine.processor()}, {machine.cores()} cores,',
        f'for a picture of {settings["width"]} x {settings["height"]} pixels and a camera at '
        f'{settings["camera.distance"]:g} m.',
        f'Give it to {", ".join(nodes[:-1])} and {nodes[-1]}, after your own params file.',
        '',
        f'Follows: {verdict.error_px:.2g} px (RMS) after {search.seconds:.2g} s from a common '
        f'state ({min(of_shots):.2g} to {max(of_shots):.2g} px in {len(of_shots)}',
        f'shots of other gusts, {min(verdict.errors_px):.2g} to {max(verdict.errors_px):.2g} px '
        f'in their {len(verdict.errors_px)} windows); {options.error_px:g} px are allowed.',
        f'By that spread, and by the own error of the reference, {verdict.own_px:.2g} px, other '
        'shots may reach',
        f'{verdict.bound_px:.2g} px'
        + _kept(choice.is_accurate, '; nothing that was tried is better at this rate'),
        *(['That is more; but your own settings keep it in all shots but one, so that nothing '
           'dearer is taken.']
          if choice.is_accurate and verdict.bound_px > options.error_px else []),
        'Such a number tells something until the horizon, where two converged runs part: '
        + (f'{horizon:.2g} s.' if horizon else 'more than 0.6 s.'),
        *(['THAT IS SOONER: what was asked is mostly chance, and behaves tells more.']
          if horizon and horizon < search.seconds else []),
        f'Behaves: over {LENGTH:.0f} s its statistics are {verdict.behaves:.2g} times as far from '
        "the reference's (RMS) as",
        f'those are from one another in other gusts; {behaves.WITHIN:g} are allowed'
        + _kept(verdict.behaves <= behaves.WITHIN, ''),
        f'Rests: {verdict.rests:.2g} mm/s are left in calm air, {rests.SLOW:g} are allowed; it '
        f'hangs {verdict.sag_mm:.0f} mm deeper than statics'
        + _kept(choice.is_sound or verdict.behaves > behaves.WITHIN, ''),
        f'Cost: {verdict.cost_ms:.2g} ms of processor time a frame, physics and drawing, without '
        'messages;',
        f'{100.0 * verdict.cost_ms / frame_ms:.2g} % of the {frame_ms:.3g} ms at '
        f'{options.rate:g} Hz; {100.0 * MAX_LOAD:.0f} % are allowed'
        + _kept(choice.is_fast, f' by {verdict.cost_ms - search.limit_ms:.2g} ms; nothing that '
                'was tried is faster'),
        f'Reference: {judge.finest[1]} x {judge.finest[0]} nodes for what follows, '
        f'{judge.middle[1]} x {judge.middle[0]} for the rest.']
    if shot['gust.intensity'] != settings['gust.intensity']:
        lines.append(
            f'Measured in gusts of {shot["gust.intensity"]:g}, where your shot has '
            f'{settings["gust.intensity"]:g}: in a steady wind all moments are alike.')
    if search.chosen(verdict.name)['damping'] != settings['damping']:
        lines.append('damping is a ratio for one spring: it is scaled with the grid, so that the '
                     'sheet stays the same.')
    others = load_of_others(search.store)
    if machine.is_busy(others):
        lines.append(f'The machine was busy: others took {others:.1f} of its processors, which '
                     'may lengthen even processor times.')
    return lines


if __name__ == '__main__':
    sys.exit(main())
