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

"""Solvers and precisions that change while a real node runs, as by `ros2 param set` on physics."""
from flag_sim.cloth import Cloth
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
import numpy as np
from support.forked import Graph
from support.frames import parameters_message
from support.watch import eventually, Watcher

WIND = (6.0, 2.0, 0.5)
# Every solver, then the precision there and back.
SWITCHES = [*(('solver', name) for name in [*SOLVERS][::-1]), ('precision', 'float32'),
            ('precision', 'float64')]
STAMPS = [round(n * 1e9 / 30.0) for n in range(10 + 4 * len(SWITCHES))]


def of_stamp(clouds, stamp):
    """Return the clouds of a frame among those that were heard."""
    return [cloud for cloud in clouds if messages.to_stamp(cloud.header.stamp) == stamp]


def test_solvers_and_precisions_take_over_from_one_another_without_a_jump(tmp_path, domain):
    """
    Each for four frames, in another process, over DDS: the motion is the library's to the bit.

    And no frame moves the cloth three times as far as the one before, nor a third as far: a
    velocity in other units or lost would.
    """
    turns = {10 + 4 * n: switch for n, switch in enumerate(SWITCHES)}
    cloth = Cloth()
    flights = []
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        parameters, clouds = watcher.publisher('parameters'), watcher.listen('vertices')
        graph.start('physics')
        client = watcher.parameters_of('physics')
        for n, stamp in enumerate(STAMPS):
            before = cloth.positions
            if n in turns:
                assert watcher.put(client, *turns[n]).successful
                setattr(cloth, *turns[n])
            message = parameters_message('/wind', FrameId(stamp, 1, n, n), WIND, {})
            # Sending again is harmless, and needed until the node's reader is known.
            eventually(lambda: parameters.publish(message) or of_stamp(clouds, stamp), watcher)
            positions, _ = messages.read_cloud(of_stamp(clouds, stamp)[0])
            if n > 0:
                cloth.advance((stamp - STAMPS[n - 1]) * 1e-9, WIND)
                flights.append(np.abs(cloth.positions - before).max())
            assert np.array_equal(positions, cloth.positions.astype(np.float32)), turns.get(n)
        assert graph.end('physics') == 0
    change = np.diff(np.log(flights[4:]))
    assert np.abs(change).max() < np.log(3.0)
