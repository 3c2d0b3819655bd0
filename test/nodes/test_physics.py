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

"""The physics node, in this process: what it says of its steps, and how it goes on."""
from flag_sim.cloth import Cloth
from flag_sim.declarations.moving_cloth import warm_up
from flag_sim.declarations.nodes import defaults
from flag_sim.nodes.physics import Physics
from flag_sim.protocol.frames import FrameId
import numpy as np
import pytest
import rclpy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2

SMALL = {'grid.columns': 7, 'grid.rows': 5}


class Run:
    """A node that is given frames by hand."""

    def __init__(self, node, capfd):
        self._node = node
        self._capfd = capfd
        self._index = 0

    def frame(self, wind=(0.0, 3.0, 0.0), rate=30.0, **parameters):
        """Return the positions (rows, columns, 3) [m] of the next frame and what was logged."""
        stamp = round(self._index * 1e9 / rate)
        values = {**self._node.values, **SMALL,
                  **{name.replace('__', '.'): value for name, value in parameters.items()}}
        cloud = deserialize_message(
            self._node.work(FrameId(stamp, 1, self._index, 0), wind, values), PointCloud2)
        self._index += 1
        points = np.frombuffer(cloud.data, np.float32).reshape(cloud.height, cloud.width, -1)
        return points[..., :3].copy(), self._capfd.readouterr().err

    def restart(self):
        """Begin with the first frame again, as after `reset`."""
        self._index = 0
        self._node.restart(FrameId(0, 2, 0, 0))


@pytest.fixture
def run(domain, capfd, still_log):
    """Return a physics node that waits for frames."""
    rclpy.init(domain_id=domain)
    node = Physics()
    capfd.readouterr()
    yield Run(node, capfd)
    node.destroy_node()
    rclpy.shutdown()


def calm(run, **parameters):
    """Play two seconds, all but the last frame of which must pass without a word; return its."""
    for _ in range(59):
        assert run.frame(**parameters)[1] == ''
    # The sum of the frames' times may be a rounding short of two seconds.
    return run.frame(**parameters)[1] + run.frame(**parameters)[1]


def test_too_few_substeps_are_refined_and_told_once(run):
    """Asked, needed and granted; the frame is the one that stability asks for."""
    run.frame(substeps=2)
    refined, said = run.frame(substeps=2)
    assert 'substeps = 2 is not stable: the frame needs ' in said
    again, said = run.frame(substeps=2)
    assert 'substeps' not in said
    assert 'the steps that substeps sets are enough again' in calm(run, substeps=900)
    run.restart()
    run.frame()
    assert np.array_equal(run.frame()[0], refined)
    assert np.array_equal(run.frame()[0], again)


def test_steps_over_budget_are_told_once(run):
    """Needed, granted and what is left of the stiffness; and when that ends."""
    stiff = {'stiffness': 1e7, 'substeps_limit': 20, 'substeps': 10}
    run.frame(**stiff)
    _, said = run.frame(**stiff)
    assert 'substeps = 10 is not stable' in said
    assert 'substeps_limit allows 20: stiffness is lowered to' in said
    assert run.frame(**stiff)[1] == ''
    said = calm(run)
    assert 'stiffness and damping are back at what is set: the frame needs ' in said


def test_steps_that_are_over_budget_now_and_then_are_told_once(run):
    """As where frames are dropped: the one after the gap needs twice the steps."""
    heard = [run.frame(substeps_limit=100, stiffness=1e7 if n % 20 == 10 else 10.0)[1]
             for n in range(100)]
    assert [n for n, said in enumerate(heard) if 'stiffness' in said] == [10]
    assert 'substeps_limit allows 100: stiffness is lowered to' in heard[10]


def test_the_wind_of_a_frame_blows_in_it(run):
    """The library's cloth in the same wind, to the bit of float32: neither late nor early."""
    cloth = Cloth(5, 7)
    run.frame((0.0, 1.0, 0.0))
    for speed in (8.0, -3.0, 5.0):
        cloth.advance(round(1e9 / 30.0) * 1e-9, (0.0, speed, 0.0))
        found, _ = run.frame((0.0, speed, 0.0))
        np.testing.assert_allclose(found, cloth.positions, atol=1e-5)


STORM = {'solver': 'seed', 'air__law': 'seed', 'area_density': 1e-6, 'damping': 0.0,
         'substeps_limit': 5, 'stretch_limit': 1e6}
"""A sheet of a milligram a square metre in a storm; by eq. 1.3 as published nothing slows it."""


@pytest.mark.parametrize('way_out', ['reset', 'parameter'])
def test_a_frame_that_diverges_is_held_and_the_node_goes_on(run, way_out):
    """It repeats the last good frame, says why, and moves on after a reset or another value."""
    warm_up({**defaults('physics'), 'solver': 'seed'})  # while it lacks, another one goes on
    run.frame(**STORM)
    for _ in range(200):
        held, said = run.frame((0.0, 190.0, 0.0), **STORM)
        if 'is held where the frame began' in said:
            break
    else:
        pytest.fail('it did not diverge')
    assert 'no step is stable for seed; symplectic is stable in steps of' in said
    assert np.array_equal(run.frame((0.0, 190.0, 0.0), **STORM)[0], held)
    if way_out == 'reset':
        run.restart()
        run.frame()
    for _ in range(3):
        moved, _ = run.frame()
        assert np.isfinite(moved).all() and not np.array_equal(moved, held)
        held = moved
