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

"""Lockstep across two hosts, over a network that loses and delays, loses no frame."""
import re
import statistics
import time

import pytest
from support.hosts import HostsGraph, Network, why_not
from support.shot import film, messages_of, stamp_of
from support.soak import SOAK

MISSING = why_not()
pytestmark = pytest.mark.skipif(MISSING is not None, reason=f'no hosts: {MISSING}')
soak = pytest.mark.skipif(not SOAK, reason='make soak tries every network')
FRAMES = 200 if SOAK else 10
TURNS = 3


def filmed(folder, network, **options):
    """
    Film across a network; assert that every frame arrived.

    Return how long it took [s]: all of it, from the nodes' start to the recorder's end, and the
    frames alone, from the first message that was recorded to the last.
    """
    with network, HostsGraph(folder / 'log', network, **options) as graph:
        begin = time.monotonic()
        status = film(graph, folder / 'bag', FRAMES, seconds=180.0)
        whole = time.monotonic() - begin
        assert status == 0, graph.log('wind')
        # What nodes tell by NOTIFY_SOCKET does not leave their network; their log does.
        took = re.search(r'served \d+ frames in ([\d.]+) s', graph.log('recorder'))
    for topic in ('/camera/image_raw', '/camera/camera_info', '/vertices'):
        stamps = [stamp_of(message) for _, message in messages_of(folder / 'bag', topic)]
        assert stamps == [round(n * 1e9 / 30.0) for n in range(FRAMES)], topic
    return whole, float(took[1])


def test_every_frame_arrives_where_one_in_twenty_is_lost(tmp_path):
    """Frames of Ethernet, that is; images and vertices cross in many of them."""
    network = Network(loss=0.05)
    filmed(tmp_path, network)
    assert network.lost > 0.02 * network.passed > 0


@soak
@pytest.mark.parametrize('peers', [False, True])
@pytest.mark.parametrize('delay', [0.0, 0.02])
def test_what_is_lost_takes_half_as_long_again_at_most(tmp_path, delay, peers):
    """In turns with no loss, medians; hosts find one another by multicast or by given peers."""
    took = {0.0: [], 0.05: []}
    for turn in range(TURNS):
        for loss, times in took.items():
            folder = tmp_path / f'{turn}-{loss}'
            times.append(filmed(folder, Network(loss, delay), peers=peers))
    (clean, clean_frames), (lossy, lossy_frames) = (
        map(statistics.median, zip(*times)) for times in took.values())
    print(f'delay {delay} s, peers {peers}: {FRAMES} frames in {clean:.1f} s, with 5 % lost in '
          f'{lossy:.1f} s, {lossy / clean:.2f} times; without the start {clean_frames:.1f} and '
          f'{lossy_frames:.1f} s, {lossy_frames / clean_frames:.2f} times; each: {took}')
    assert lossy <= 1.5 * clean


def test_containers_that_share_a_network_but_no_memory(tmp_path):
    """Whoever comes second sees that shared memory does not lead to the first."""
    filmed(tmp_path, Network(shared=True))
