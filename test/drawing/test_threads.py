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

"""Any number of threads makes the same picture, and the choice among them is the fastest."""
import threading
import time

from flag_sim.drawing import Camera, Style
from flag_sim.drawing.bands import BAND
from flag_sim.drawing.multisample import TILE
from flag_sim.drawing.picture import WORTH_SHARING
from flag_sim.jit.kernels import kernel
from flag_sim.parallel import thread_pool
from flag_sim.parallel.atomics import fetch_add

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

STYLES = {
    'plain': Style(), 'samples': Style(samples=4), 'outline': Style(outline=True, samples=8),
    'painter': Style(hidden_surface='painter', shading='flat'),
    'perspective': Style(interpolation='perspective')}


@pytest.mark.parametrize('name', STYLES)
@pytest.mark.parametrize('width, height', [(640, 480), (61, 47), (3, 100), (50, 1)])
def test_the_same_picture_to_the_bit(name, width, height):
    one = DepthPicture(threads=1)
    others = [DepthPicture(threads) for threads in (0, 2, 3, 7)]
    for phase in range(4):
        look = {'camera': Camera(width, height, elevation=0.2 * phase), 'style': STYLES[name]}
        rgb = one.draw(wave(phase=phase), **look).colour
        for other in others:
            np.testing.assert_array_equal(other.draw(wave(phase=phase), **look).colour, rgb)
            np.testing.assert_array_equal(other.frame.depth, one.frame.depth)


def test_the_same_picture_where_vertices_are_shared_too():
    # More pieces of points and of triangles than are worth sharing.
    for style in (STYLES['plain'], STYLES['painter']):
        one, two = DepthPicture(1), DepthPicture(2)
        for phase in range(3):
            flag = wave(rows=150, columns=301, phase=phase)
            np.testing.assert_array_equal(two.draw(flag, style=style).colour,
                                          one.draw(flag, style=style).colour)
        assert sum(map(len, one._scene.pieces)) > WORTH_SHARING


def test_threads_are_awake_in_a_frame_alone():
    # One waking a frame: they stay for the next deal, and sleep when the frame is over.
    pool, called = thread_pool.ThreadPool(2), []

    def work(number):
        called.append(number)
        while len(called) % 2:  # until the other one is here
            time.sleep(1e-4)

    with pool:
        pool.wake()
        for _ in range(5):
            pool.parallel_for(work)
    assert sorted(called) == [0] * 5 + [1] * 5
    pool._executor.submit(int).result(10.0)  # its only thread is free again
    assert pool._awake == set()


def test_bands_hold_whole_tiles():
    # Or else a tile would be drawn by two bands, one part in each.
    assert BAND % TILE == 0


@pytest.mark.parametrize('seconds, chosen', [
    ({1: 1.0, 2: 0.6, 4: 0.4}, 4), ({1: 1.0, 2: 0.6, 4: 0.58}, 2), ({1: 1.0, 2: 0.95, 4: 1.5}, 1)])
def test_the_choice(monkeypatch, seconds, chosen):
    now = [0.0]
    monkeypatch.setattr(thread_pool.os, 'sched_getaffinity', lambda process: range(4))
    monkeypatch.setattr(thread_pool.time, 'perf_counter', lambda: now[0])
    pool = thread_pool.ThreadPool(0)
    drawn = []
    for number in range(30):
        with pool:
            drawn.append(pool.threads)
            # Now and then something else holds a frame up.
            now[0] += seconds[pool.threads] * (3.0 if number % 4 == 0 else 1.0)
    assert set(drawn[:-3]) == {1, 2, 4}
    assert pool.threads == chosen


def test_an_error_in_a_thread_is_not_lost():
    def work(band, bands):
        if band == 1:
            raise ValueError('of the second band')
    with pytest.raises(ValueError, match='second'):
        thread_pool.ThreadPool(2).run_bands(work)
    with pytest.raises(ValueError, match='second'):
        thread_pool.ThreadPool(2).parallel_for(lambda number: time.sleep(0.05) or work(number, 2))


def test_who_comes_late_is_not_waited_for():
    # One that is busy elsewhere, as where a processor has other things to do.
    pool, called, is_over = thread_pool.ThreadPool(2), [], threading.Event()
    busy = pool._executor.submit(is_over.wait, 10.0)
    pool.parallel_for(called.append)
    is_over.set()
    busy.result()
    assert called == [0]


def test_pieces_are_dealt_once_each():
    @kernel(cache=False)
    def deal_all(taken, times):
        while True:
            piece = fetch_add(taken, 0, 1)
            if piece >= times.size:
                break
            times[piece] += 1

    taken, times = np.zeros(1, np.int64), np.zeros(300_000, np.int64)
    deal_all(taken, times[:0])
    taken[:] = 0
    # The threads' own places in `times` never overlap, if each piece is dealt to one alone.
    thread_pool.ThreadPool(4).parallel_for(lambda number: deal_all(taken, times))
    np.testing.assert_array_equal(times, 1)
    assert taken[0] > times.size
