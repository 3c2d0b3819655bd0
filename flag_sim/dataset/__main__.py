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

"""Make a dataset: thousands of clips of flags in the wind, drawn from a recipe."""
import argparse
from collections.abc import Iterable, Sequence
import contextlib
import dataclasses
import importlib.util
import sys
import threading
import time

from flag_sim.dataset import engine, manifest
from flag_sim.dataset.clip import versions
from flag_sim.dataset.laws import Law
from flag_sim.dataset.marked_yaml import MarkedError
from flag_sim.dataset.recipe import MOST_CLIPS, read_recipe, Recipe
from flag_sim.dataset.shot import check, NoClip
from flag_sim.dataset.store import Shard, Store, StoreError
from flag_sim.dataset.verification import verify
from flag_sim.jit.cache import compilations
from flag_sim.parameters.arguments import given_path

NEEDED = {'yaml': 'pyyaml', 'pyarrow': 'pyarrow', 'tqdm': 'tqdm'}
TRIED = 16
"""How many clips are drawn before any is made: a recipe of which none can be is refused."""
MOST_CHOICES = 64
"""Of up to so many choices each is tried by itself."""
KEPT = 'what is whole is kept, and the same command goes on from here'
LOOK = 0.5
"""How often it is looked whether kernels are compiled [s]."""
SHOWN = 10
"""How many of the clips that could not be made are shown."""


def main(args: Sequence[str] | None = None) -> int:
    """Make, or verify, a dataset; return the exit status."""
    parser, options = _options(args)
    for module, name in NEEDED.items():
        if importlib.util.find_spec(module) is None:
            parser.error(f"a dataset needs {name}: pip install 'flag_sim[dataset]'")
    try:
        recipe = read_recipe(options.recipe)
        if not options.verify:
            _try(recipe)
    except MarkedError as error:
        print(error, file=sys.stderr)
        return 2
    clips = recipe.clips if options.clips is None else options.clips
    shard = options.shard or Shard()
    store = Store(options.output, shard.tag)
    try:
        if options.verify:
            return verify(store, shard.numbers(clips))
        with store.opened(recipe, versions()['flag_sim']):
            return _run(recipe, store, options, shard.numbers(clips))
    except StoreError as error:
        print(f'dataset: {error}', file=sys.stderr)
        return 1


def _options(args):
    parser = argparse.ArgumentParser(
        prog='dataset', description=__doc__,
        epilog='A run that was interrupted goes on by the same command.')
    parser.add_argument('recipe', type=given_path, help='a YAML file, as config/flag_wind.yaml')
    parser.add_argument('--output', type=given_path, required=True, metavar='DIR',
                        help="the dataset's folder")
    parser.add_argument('--clips', type=_count, metavar='N',
                        help='how many clips (as the recipe says)')
    parser.add_argument('--shard', type=_shard, metavar='I/N',
                        help='make the I-th of N parts, in this process alone, without Dask')
    parser.add_argument('--scheduler', metavar='ADDRESS',
                        help='of a Dask cluster whose workers see DIR (a process a processor)')
    parser.add_argument('--verify', action='store_true',
                        help='make nothing, and compare every clip with its digest')
    options = parser.parse_args(args)
    if options.scheduler and options.shard:
        parser.error('--shard makes its clips without a --scheduler')
    return parser, options


def _count(text):
    with contextlib.suppress(ValueError):
        if 1 <= int(text) <= MOST_CLIPS:
            return int(text)
    raise argparse.ArgumentTypeError(f'must be a whole number from 1 to {MOST_CLIPS}, not {text}')


def _shard(text):
    with contextlib.suppress(ValueError):
        number, count = map(int, text.split('/'))
        if 1 <= number <= count <= MOST_CLIPS:
            return Shard(number, count)
    raise argparse.ArgumentTypeError(f'must be I/N with 1 <= I <= N, as 3/100, not {text}')


def _try(recipe: Recipe) -> None:
    """Raise MarkedError where none of the first clips can be made, or none with some choice."""
    reason = _why_none(recipe, min(TRIED, recipe.clips))
    if reason:
        raise MarkedError(f'no clip of this recipe can be made: {reason}')
    choices = [(name, value) for name, law in recipe.laws.items() if law.name == 'choice'
               for value in law.values]
    for name, value in choices if len(choices) <= MOST_CHOICES else ():
        reason = _why_none(dataclasses.replace(
            recipe, laws={**recipe.laws, name: Law('fixed', (value,))}), TRIED)
        if reason:
            raise MarkedError(f'no clip whose {name} is {value} can be made: {reason}')


def _why_none(recipe, count):
    """Return why none of the first `count` clips can be made, or '' where one can."""
    reason = ''
    for number in range(count):
        try:
            check(recipe.draw(number))
            return ''
        except NoClip as error:
            reason = str(error)
    return reason


def _run(recipe, store, options, numbers):
    done = {row['number'] for row in manifest.rows_of(store, numbers)
            if not row.get('is_retried', False)}
    lacking = (number for number in numbers if number not in done)
    print(f'{len(done)} of {len(numbers)} clips are there', flush=True)
    job = engine.Job(recipe.text, str(store.folder.absolute()), store.tag)
    status = 0
    try:
        with contextlib.ExitStack() as stack:
            if len(done) < len(numbers) and not options.scheduler:
                with _compiling():
                    engine.warm_up(recipe)
            if options.shard or len(done) == len(numbers):
                rows = engine.alone(job, lacking)
            else:
                client = stack.enter_context(engine.cluster(options.scheduler))
                print(f'Dask dashboard: {client.dashboard_link}', flush=True)
                engine.check_workers(client, store.folder.absolute(), versions()['flag_sim'])
                rows = engine.on_cluster(client, job, lacking)
            _follow(rows, len(numbers) - len(done))
    except KeyboardInterrupt:
        print('\ninterrupted; the same command goes on from here', file=sys.stderr)
        status = 130
    except OSError as error:
        what = f'{store.folder} cannot be written: {error.strerror}' if error.errno else error
        print(f'dataset: {what}; {KEPT}', file=sys.stderr)
        status = 1
    except StoreError as error:
        print(f'dataset: {error}; {KEPT}', file=sys.stderr)
        status = 1
    return _finish(store, numbers, status)


@contextlib.contextmanager
def _compiling():
    """Say, once, that kernels are compiled in the `with` block, if they are."""
    before, over = compilations(), threading.Event()

    def tell():
        while not over.wait(LOOK):
            if compilations() > before:
                print('compiling what clips need, a minute or more; it is kept for later runs',
                      flush=True)
                return
    teller = threading.Thread(target=tell, name='tells of compiling', daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()


def _speed(frames, seconds):
    """Return frames a second in words, with two digits at least."""
    speed = frames / max(seconds, 1e-9)
    return f'{speed:.0f} frames/s' if speed >= 10.0 else f'{speed:.2g} frames/s'


def _follow(rows: Iterable[dict], count: int) -> None:
    """Show how far the clips are."""
    from tqdm import tqdm
    begin, frames = time.monotonic(), 0
    with tqdm(total=count, unit='clip', disable=None) as bar:
        for row in rows:
            frames += row['frames']
            bar.set_postfix_str(_speed(frames, time.monotonic() - begin), refresh=False)
            bar.update()
    if frames:
        seconds = time.monotonic() - begin
        print(f'{frames} frames in {seconds:.1f} s, {_speed(frames, seconds)}')


def _finish(store, numbers, status):
    """Write the manifest, and say what could not be made; return the exit status."""
    counts, failed, size, asked = {'whole': 0, 'failed': 0}, [], 0, 0

    def counted():
        nonlocal size, asked
        for row in manifest.all_rows(store, numbers):
            counts[row['status']] += 1
            asked += row['number'] in numbers
            size += row['bytes']
            if row['status'] == 'failed' and len(failed) < SHOWN:
                failed.append(f'clip {row["number"]}: {row["reason"]}')
            yield row

    manifest.write(store.manifest, counted())
    print(f'{store.folder}: {counts["whole"]} clips of {size / 1e9:.3g} GB, '
          f'{counts["failed"]} could not be made, '
          f'{len(numbers) - asked} are not there yet')
    for line in failed:
        print(line, file=sys.stderr)
    if counts['failed'] > SHOWN:
        print(f'and {counts["failed"] - SHOWN} more: they are in {store.manifest}',
              file=sys.stderr)
    return status or int(not counts['whole'])


if __name__ == '__main__':
    sys.exit(main())
