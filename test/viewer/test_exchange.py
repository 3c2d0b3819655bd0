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

"""The two boxes between the threads."""
import threading

from flag_sim.protocol.cdr_image import ImageBytes
from flag_sim.viewer.exchange import Exchange, FramePlace, PLACES


def picture(stamp):
    """Return a picture of one pixel."""
    return ImageBytes(stamp, 1, 1, 'mono8', False, 1, memoryview(b'\0'))


def test_of_pictures_the_latest_waits_and_the_others_are_counted():
    exchange = Exchange()
    for stamp in range(5):
        exchange.put_place(FramePlace(stamp, 1, stamp + 100))
        exchange.put_picture(picture(stamp))
    news, (shown, place) = exchange.news()
    assert (news, shown.stamp, place.index, exchange.left_out) == ([], 4, 104, 4)
    assert exchange.news() == ([], None)


def test_places_of_frames_without_a_picture_are_forgotten():
    exchange = Exchange()
    for stamp in range(10 * PLACES):
        exchange.put_place(FramePlace(stamp, 1, stamp))
    assert len(exchange._places) == PLACES
    exchange.put_picture(picture(3))
    assert exchange.news()[1][1] is None


def test_the_window_is_woken_once_until_it_takes():
    exchange, woken = Exchange(), []
    exchange.post('before there is a window')
    exchange.wake_window = lambda: woken.append(1)
    exchange.wake_window()
    exchange.post('a')
    assert exchange.news()[0] == ['before there is a window', 'a'] and len(woken) == 1
    exchange.post('b')
    exchange.put_picture(picture(1))
    assert len(woken) == 2


def test_nothing_is_lost_between_threads():
    exchange, taken = Exchange(), []
    threads = [threading.Thread(target=lambda: [exchange.ask(n) for n in range(1000)])
               for _ in range(4)]
    for thread in threads:
        thread.start()
    while len(taken) < 4000:
        taken += exchange.requests()
    assert sorted(taken) == sorted([*range(1000)] * 4)
    for thread in threads:
        thread.join()
