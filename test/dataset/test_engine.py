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

"""Workers: one that is killed loses no clip, and the clips are those of one process alone."""
import asyncio
import contextlib
import gc
import os
import signal
import time

from flag_sim.dataset import Clips, engine
from flag_sim.dataset.__main__ import main
from flag_sim.dataset.clip import versions
from flag_sim.dataset.recipe import recipe_of
from flag_sim.dataset.store import Store, StoreError
import pytest
from support.recipes import text
from support.soak import SOAK
from support.tasks import fail

CLIPS, KILLS, DASKS = (100, 10, 3) if SOAK else (6, 1, 0)
"""DASKS: how often Dask itself begins a clip again; 3 is its default."""
LONG = text({'frames: 4': f'frames: {200 if SOAK else 50}'})


@pytest.fixture(scope='module')
def shared():
    """Return a client of two workers; in short, a task whose worker died comes back at once."""
    import dask
    with dask.config.set({'distributed.scheduler.allowed-failures': DASKS}):
        with engine.cluster(None, workers=2) as client:
            yield client


@pytest.fixture
def client(shared):
    """Return that client once both workers are there, those too that replace killed ones."""
    shared.wait_for_workers(2)
    return shared


@pytest.fixture
def job(tmp_path):
    """Return a Job whose folder is there."""
    store = Store(tmp_path / 'set')
    store.making.mkdir(parents=True)
    return engine.Job(LONG, str(store.folder), '')


def digests(rows):
    return {row['number']: row['content'] for row in rows}


def test_killed_workers_lose_no_clip(client, job, tmp_path):
    """By SIGKILL, in the midst of clips; the digests are those of one process."""
    killed, rows = 0, []
    for row in engine.on_cluster(client, job, range(CLIPS)):
        rows.append(row)
        if killed < KILLS and len(rows) >= (killed + 1) * CLIPS // (KILLS + 1):
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
            killed += 1
    assert killed == KILLS and len(rows) == CLIPS
    assert {row['status'] for row in rows} == {'whole'}
    alone = Store(tmp_path / 'alone')
    alone.making.mkdir(parents=True)
    others = engine.alone(engine.Job(LONG, str(alone.folder), ''), range(CLIPS))
    assert digests(rows) == digests(others) and len(digests(rows)) == CLIPS


def test_what_no_worker_can_make_is_listed(client, monkeypatch):
    """One that kills its workers, and one with a fault; a full disk ends the run."""
    monkeypatch.setattr(engine, 'DEATHS', 1)
    monkeypatch.setattr(engine, 'QUEUED', 1)

    def broken(number, reason):
        return {'number': number, 'reason': reason}
    rows = {row['number']: row.get('reason') for row in engine.spread(
        client, fail, [0, 1, 2, 4], broken)}
    assert rows == {0: None, 1: 'its workers died again and again',
                    2: 'ZeroDivisionError: a fault', 4: None}
    with pytest.raises(OSError, match='No space'):
        list(engine.spread(client, fail, [0, 3], broken))


def test_a_lost_scheduler_ends_the_run(client, monkeypatch):
    """Its clips are cancelled then."""
    def lost(future):
        raise asyncio.CancelledError
    monkeypatch.setattr('distributed.Future.exception', lost)
    with pytest.raises(StoreError, match='the scheduler is gone'):
        list(engine.spread(client, abs, [0], None))


def test_the_command_uses_a_cluster_that_is_there(client, tmp_path, capsys):
    (tmp_path / 'mine.yaml').write_text(text())
    arguments = [str(tmp_path / 'mine.yaml'), '--output', str(tmp_path / 'set')]
    assert main([*arguments, '--scheduler', client.scheduler.address]) == 0
    assert 'Dask dashboard: http' in capsys.readouterr().out
    assert len(Clips(tmp_path / 'set')) == 3


def test_workers_that_cannot_make_clips_are_told_of_at_once(client, tmp_path):
    """They have another flag_sim, or do not see the folder: they would wait or fail for ever."""
    for folder, version, words in ((tmp_path, versions()['flag_sim'], 'see .*: name a folder'),
                                   (tmp_path, '0.0.1', 'version 0.0.1')):
        with pytest.raises(StoreError, match=words):
            engine.check_workers(client, folder, version)


def test_workers_watch_themselves_less_than_dask_does_by_default(client):
    """And keep the memory that they have; those that replace killed workers too."""
    def told(dask_worker):
        return (os.getpid(), os.environ.get('MALLOC_TRIM_THRESHOLD_'),
                [name for name, callback in dask_worker.periodic_callbacks.items()
                 if callback.callback_time < 500.0])
    first = client.run(told)
    assert len(first) == 2 and all(told[1:] == (None, []) for told in first.values())
    killed, (process, *_) = first.popitem()
    os.kill(process, signal.SIGKILL)
    deadline = time.monotonic() + 60.0
    while killed in client.scheduler_info()['workers'] or sum(client.nthreads().values()) < 2:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    then = client.run(told)
    assert process not in {told[0] for told in then.values()}
    assert all(told[1:] == (None, []) for told in then.values())


def test_no_scheduler_is_said_to_be_none():
    with pytest.raises(StoreError, match='no scheduler at nothing://here'):
        with engine.cluster('nothing://here'):
            pass


def test_workers_that_die_as_they_start_are_begun_anew(monkeypatch):
    """A few times; where none ever starts there is one line."""
    starts = []

    def start(**options):
        starts.append(options)
        if len(starts) != 3:
            raise RuntimeError('Nanny failed to start.') from OSError('a worker died')
        return contextlib.nullcontext('nothing://here')
    monkeypatch.setattr('distributed.LocalCluster', start)
    for words in ('no scheduler at nothing://here', 'the workers do not start: a worker died'):
        with pytest.raises(StoreError, match=words):
            with engine.cluster(None, workers=1):
                pass
    assert len(starts) == 6


def test_workers_do_not_hear_the_interrupt_of_a_terminal(client):
    """It goes to all processes of a command; those that replace killed workers included."""
    workers = client.run(signal.pthread_sigmask, signal.SIG_BLOCK, [])
    assert workers and all(signal.SIGINT in blocked for blocked in workers.values())
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    processes = client.run(os.getpid)
    for process in processes.values():
        os.kill(process, signal.SIGINT)
    assert client.run(os.getpid) == processes


def test_an_interrupt_while_a_row_is_fetched_logs_nothing(client, caplog):
    """Dask's own task is forgotten then; what else goes wrong in a task is told."""
    future = client.submit(abs, 1, resources={'none': 1}, pure=False)  # which nobody has

    async def interrupted():
        fetching = asyncio.ensure_future(client._gather([future]))
        await asyncio.sleep(0.05)
        fetching.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await fetching
        await client._cancel([future])
        await asyncio.sleep(0.05)
        gc.collect()
        asyncio.ensure_future(broken())
        await asyncio.sleep(0.05)
        gc.collect()

    async def broken():
        raise ZeroDivisionError('a fault')
    client.sync(interrupted)
    assert [type(one.exc_info[1]).__name__ for one in caplog.records if one.name == 'asyncio'] == [
        'ZeroDivisionError']


def test_what_clips_need_is_compiled_before_workers_begin(monkeypatch):
    """Two frames of a clip, with every channel; one that cannot be made is no matter."""
    made = []
    monkeypatch.setattr(engine, 'arrays_of', lambda view, names: made.append(names) or {})
    engine.warm_up(recipe_of(text()))
    assert made == [('vertices', 'wind')] * 2
    engine.warm_up(recipe_of(text(more='  physics.max_gap: 0.0\n')))
    assert len(made) == 2
