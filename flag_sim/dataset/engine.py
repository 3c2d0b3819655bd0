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
Who makes the clips: this process alone, or the workers of a Dask cluster.

Only the numbers of clips go to workers, and their rows come back: what is large is written where
it is made.
"""
import asyncio
from collections.abc import Callable, Iterable, Iterator
import contextlib
import functools
import importlib
import importlib.metadata
import itertools
import logging
import math
import multiprocessing.resource_tracker
import os
from pathlib import Path
import signal
import tempfile
import time
from typing import NamedTuple

from flag_sim.dataset import clip
from flag_sim.dataset.channels import arrays_of
from flag_sim.dataset.npz import NpzWriter
from flag_sim.dataset.recipe import Recipe
from flag_sim.dataset.store import Store, StoreError

NO_DASK = "workers need dask: pip install 'flag_sim[dataset]'; or name a --shard"
DEATHS = 3
"""
How often what a worker died of is begun: a start, or a clip, which Dask has begun several times.
"""
QUEUED = 4
"""How many clips a worker has waiting, so that it never waits for one."""
ASKED = 1.0
"""How often the scheduler is asked how many workers there are [s]."""
OF_CLUSTER = {
    'distributed.worker.profile.enabled': False,
    'distributed.admin.tick.interval': '500ms',
    'distributed.admin.system-monitor.interval': '2s',
    'distributed.worker.memory.monitor-interval': '1s',
    'distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_': None,
}
"""
How a cluster of this machine differs from Dask's defaults, to leave the processors to the clips.

By default Dask looks 100 times a second where a worker is in its code, 50 times a second whether
each event loop still answers, and 10 times how much memory each process has. And it has workers
give back their memory to the system at once: a frame's arrays would be new memory in every frame,
which is slow, as the system hands it out page by page.
"""


class Job(NamedTuple):
    """What a worker needs to know: the recipe's text, and the folder with the run's tag."""

    text: str
    folder: str
    tag: str


def make(job: Job, number: int) -> dict:
    """Make a clip of a job, in whatever process; return its row."""
    return clip.make_clip(clip.cached_recipe(job.text), number, Store(job.folder, job.tag))


def broken(job: Job, number: int, reason: str) -> dict:
    """List a clip that could not be made, for a reason that is not its own; return its row."""
    recipe, store = clip.cached_recipe(job.text), Store(job.folder, job.tag)
    drawn = recipe.draw(number)
    row = {'number': number, 'split': drawn.split, 'status': 'failed', 'reason': reason,
           'is_retried': True, 'file': '', 'bytes': 0, 'sha256': '', 'frames': 0,
           'seen_frames': 0, 'softened_frames': 0, 'rate': recipe.rate, 'seed': recipe.seed,
           'recipe': recipe.digest, 'seconds': 0.0,
           **{f'version.{name}': version for name, version in clip.versions().items()},
           'parameters': clip.parameters_of(drawn)}
    store.put(number, None, '', row)
    return row


def warm_up(recipe: Recipe, number: int = 0) -> None:
    """
    Compile what clips need, in this process, so that workers find it compiled.

    What goes wrong is not told here: the clip itself will say it.
    """
    views = itertools.islice(clip.views(recipe, recipe.draw(number)), 2)
    with (contextlib.suppress(Exception), tempfile.TemporaryDirectory() as folder,
          NpzWriter(Path(folder) / 'clip', 2) as writer):
        for view in views:
            writer.append(arrays_of(view, recipe.channels))


def alone(job: Job, numbers: Iterable[int]) -> Iterator[dict]:
    """Make clips one after another in this process; yield their rows."""
    for number in numbers:
        try:
            yield make(job, number)
        except (OSError, MemoryError):
            raise
        except Exception as error:  # a fault of ours: the other clips are made all the same
            yield broken(job, number, f'{type(error).__name__}: {error}')


@contextlib.contextmanager
def cluster(address: str | None, workers: int | None = None) -> Iterator[object]:
    """
    Yield a client of the cluster at an address, or of one that is started here.

    workers: of the latter, each a process of one thread; None: one a processor that this process
    may use. Raises StoreError where there is no Dask, no scheduler, or no worker that starts.
    """
    try:
        import dask
        import distributed
    except ImportError:
        raise StoreError(NO_DASK) from None
    logging.getLogger('asyncio').addFilter(_is_told)
    with contextlib.ExitStack() as stack:
        if address is None:
            # As long as it stands: workers that replace others take what is set then.
            stack.enter_context(dask.config.set(OF_CLUSTER))
            address = stack.enter_context(_local_cluster(
                distributed, workers or len(os.sched_getaffinity(0))))
        try:
            client = stack.enter_context(distributed.Client(address))
        except (OSError, ValueError) as error:
            raise StoreError(f'no scheduler at {address}: {error}') from None
        yield client


def _local_cluster(distributed, workers):
    """Return a cluster of this machine; it is begun anew where a worker dies as it starts."""
    for _ in range(DEATHS):
        try:
            with _without_interrupts():
                return distributed.LocalCluster(
                    n_workers=workers, threads_per_worker=1, host='127.0.0.1',
                    dashboard_address='127.0.0.1:0', silence_logs=logging.CRITICAL)
        except (OSError, RuntimeError) as error:
            reason = error.__cause__ or error
    raise StoreError(f'the workers do not start: {reason}')


@contextlib.contextmanager
def _without_interrupts():
    """
    Begin threads that block SIGINT, and so do the processes that they start.

    A terminal sends Ctrl-C to all processes of a command; this one alone is to hear it, and it
    ends the others. They have the mask of the thread that starts them, from their first moment,
    and so have those that replace them. A Ctrl-C that comes in the block is served after it.
    """
    multiprocessing.resource_tracker.ensure_running()  # else it unblocks SIGINT where it begins
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _is_told(record):
    """Return whether to log what asyncio says: not how Dask's own tasks end at an interrupt."""
    return not (record.exc_info and type(record.exc_info[1]).__name__ == 'AllExit')


def check_workers(client: object, folder: Path, version: str) -> None:
    """
    Raise StoreError unless the workers that are there have this flag_sim and see the folder.

    Asked by functions of Python's own: what a worker cannot import would end it, again and again.
    """
    import distributed
    client.wait_for_workers(1)
    try:
        found = set(client.run(importlib.metadata.version, 'flag_sim').values()) - {version}
        client.run(importlib.import_module, make.__module__)
    except ImportError as error:
        raise StoreError(f'the workers cannot import flag_sim.dataset: {error}') from None
    except distributed.CommClosedError as error:
        raise StoreError(f'the workers do not answer: {error}') from None
    if found:
        raise StoreError(f'the workers have flag_sim {", ".join(sorted(found))}, and this is '
                         f'version {version}')
    if not all(client.run(os.path.isfile, str(folder / 'dataset.json')).values()):
        raise StoreError(f'not all workers see {folder}: name a folder that is shared')


def spread(client: object, task: Callable[[int], dict], numbers: Iterable[int],
           broken: Callable[[int, str], dict]) -> Iterator[dict]:
    """
    Have a cluster's workers call task(number) for each number; yield what they return.

    A number whose worker died is begun anew; broken(number, reason) is called for one that fails
    for another reason than OSError, or dies again and again, and what it returns is yielded.
    Raises OSError as a worker does: the disk is full, or not the same for all; and StoreError
    where the scheduler is lost.
    """
    import distributed
    waiting, deaths, by_key = iter(numbers), {}, {}
    room, asked = 0, -math.inf
    done = distributed.as_completed(loop=client.loop)

    def submit(number):
        future = client.submit(task, number, pure=False)
        by_key[future.key] = number
        done.add(future)

    def fill():
        nonlocal room, asked
        if time.monotonic() - asked > ASKED:
            room, asked = QUEUED * max(sum(client.nthreads().values()), 1), time.monotonic()
        for number in itertools.islice(waiting, max(room - len(by_key), 0)):
            submit(number)

    fill()
    for future in done:
        number = by_key.pop(future.key)
        try:
            error = future.exception()
        except asyncio.CancelledError:
            raise StoreError('the scheduler is gone') from None
        if error is None:
            yield future.result()
        elif isinstance(error, distributed.KilledWorker):
            deaths[number] = deaths.get(number, 0) + 1
            if deaths[number] < DEATHS:
                submit(number)
            else:
                yield broken(number, 'its workers died again and again')
        elif isinstance(error, OSError):
            raise error
        else:
            yield broken(number, f'{type(error).__name__}: {error}')
        fill()


def on_cluster(client: object, job: Job, numbers: Iterable[int]) -> Iterator[dict]:
    """Make clips on a cluster whose workers have the job's folder; yield their rows."""
    return spread(client, functools.partial(make, job), numbers,
                  functools.partial(broken, job))
