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

"""The pre-roll: a cloth that begins anew has moved already, whatever began it."""
from flag_sim.cloth import Cloth
from flag_sim.declarations.factories import cloth_of
from flag_sim.parameters.config import config_path
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from flag_sim.tools.demo import shots
import numpy as np
import pytest
import rclpy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2
from support.bench import Bench, WIND
from support.frames import parameters_message

FRAME = 1.0 / 30.0
SMALL = ('-p', 'grid.columns:=7', '-p', 'grid.rows:=5')
SECONDS = 0.51
PIECES = 16  # frames of 30 Hz at most


def rolled(wind=WIND, **cloth):
    """Return the library's cloth after the same time in the same wind."""
    cloth = Cloth(5, 7, **cloth)
    for _ in range(PIECES):
        cloth.advance(SECONDS / PIECES, wind)
    return cloth


def sent(cloth):
    """Return a cloth's positions as the node sends them."""
    return cloth.positions.astype(np.float32)


@pytest.fixture
def bench(domain):
    """Return a physics node with a pre-roll."""
    with rclpy.init(args=['--ros-args', *SMALL, '-p', f'preroll:={SECONDS}'], domain_id=domain):
        bench = Bench()
        yield bench
        bench.close()


def test_the_first_frame_has_moved_in_its_own_wind_and_the_second_goes_on(bench):
    """For just so long, and at the frame's own stamp: no frame more is sent."""
    cloth = rolled()
    assert np.array_equal(bench.frame(0.0), sent(cloth))
    assert len(bench.clouds) == 1
    cloth.advance(round(FRAME * 1e9) * 1e-9, (1.0, 5.0, 0.0))
    assert np.array_equal(bench.frame(FRAME, (1.0, 5.0, 0.0)), sent(cloth))


def test_what_is_keyed_in_the_first_frame_counts_before_it(bench):
    """The pre-roll itself can be keyed too, so that a bag holds it."""
    keyed = {'physics.gravity': 3.0}
    assert np.array_equal(bench.frame(0.0, keyed=keyed), sent(rolled(gravity=3.0)))


def test_a_keyed_preroll_wins(bench):
    """0 leaves the cloth at rest."""
    assert np.array_equal(bench.frame(0.0, keyed={'physics.preroll': 0.0}), sent(Cloth(5, 7)))


@pytest.mark.parametrize('again', ['reset', 'another wind', 'back in time'])
def test_every_new_beginning_has_it(bench, again):
    """Bytes do not depend on what was played before."""
    first = bench.frame(1.0)
    for n in range(1, 5):
        bench.frame(1.0 + n * FRAME)
    frame = {'reset': FrameId(0, 2, 0, 0), 'another wind': FrameId(10**9, 7, 0, 0),
             'back in time': FrameId(0, 1, 5, 5)}[again]
    cloud = bench.hear(parameters_message('/wind', frame, WIND, {}))
    assert np.array_equal(messages.read_cloud(cloud)[0], first)


def test_who_joins_late_begins_with_it_and_says_so(bench, capfd):
    """The flag flies at once, though not as it would have."""
    cloud = bench.hear(parameters_message('/wind', FrameId(10**9, 1, 7, 7), WIND, {}))
    assert np.array_equal(messages.read_cloud(cloud)[0], sent(rolled()))
    assert ('joined the take at frame 7: the cloth begins from its preroll there; reset for a '
            'whole take') in capfd.readouterr().err


def test_a_flag_of_another_size_has_it_too(bench):
    """It is laid out anew, in the middle of a take."""
    bench.frame(0.0)
    bench.put(**{'flag.length': 1.0})
    cloth = rolled(length=1.0)
    cloth.advance(round(FRAME * 1e9) * 1e-9, WIND)
    assert np.array_equal(bench.frame(FRAME), sent(cloth))


def test_it_ends_with_the_node(bench):
    """A minute of a fine grid must not keep a process that was told to end."""
    bench.node.context.shutdown()
    values = {**bench.node.values, 'preroll': 60.0}
    cloud = deserialize_message(bench.node.work(FrameId(0, 1, 0, 0), WIND, values), PointCloud2)
    assert np.array_equal(np.float32(messages.read_cloud(cloud)[0]), sent(Cloth(5, 7)))


@pytest.mark.parametrize('shot', shots())
def test_no_shot_begins_with_a_board(domain, shot):
    """Its first frame hangs or flies, and its edges are smooth."""
    path = str(config_path(f'{shot}.yaml'))
    with rclpy.init(args=['--ros-args', '--params-file', path], domain_id=domain):
        bench = Bench()
        assert bench.node.values['preroll'] >= 3.0
        moved = bench.frame(0.0) - cloth_of(bench.node.values).positions
        bench.close()
    assert np.linalg.norm(moved, axis=-1).max() > 0.3
