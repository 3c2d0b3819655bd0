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

"""Random parameters and frames for the physics node: it lives, and its vertices are in bounds."""
import math

from flag_sim.declarations.nodes import named
from flag_sim.ros import messages
from flag_sim.ros.parameter_node import to_parameter
from hypothesis import given, HealthCheck, Phase, settings, strategies as st
import numpy as np
import pytest
import rclpy
from support.bench import Bench
from support.soak import SOAK

DECLARATIONS = named('physics')
AFFORDABLE = {'grid.rows': 12, 'grid.columns': 12, 'substeps_limit': 20}
"""Greatest right values drawn, so that an example is over in milliseconds."""
OTHERS = st.one_of(st.none(), st.booleans(), st.integers(-2**63, 2**63 - 1), st.floats(),
                   st.text(max_size=5), st.lists(st.floats(), max_size=3))
UNKNOWN = st.text('abcdefghijklmnopqrstuvwxyz._', min_size=1, max_size=12).filter(
    lambda name: name not in DECLARATIONS)


def right(declaration):
    """Draw values that a parameter takes, its ends and whole numbers for numbers among them."""
    if declaration.is_list:
        one = st.floats(declaration.low, declaration.high)
        return st.lists(one, min_size=declaration.length, max_size=declaration.length)
    if declaration.choices:
        return st.sampled_from(declaration.choices)
    if isinstance(declaration.default, bool):
        return st.booleans()
    high = AFFORDABLE.get(declaration.name, declaration.high)
    if isinstance(declaration.default, int):
        return st.integers(declaration.low, high)
    # Uniform numbers would nearly all be near the upper end.
    wide = st.floats(-6.0, 9.0).map(lambda power: min(max(10.0**power, declaration.low), high))
    low = declaration.low
    return st.one_of(st.floats(low, high), wide, st.sampled_from([low, high]),
                     st.integers(math.ceil(low), math.floor(high)))


def accepts(name, value):
    """Return by the table alone whether a parameter takes a value."""
    declaration = DECLARATIONS.get(name)
    if declaration is None or declaration.fixed:
        return False
    if declaration.is_list:
        return (isinstance(value, list) and len(value) == declaration.length
                and all(declaration.low <= one <= declaration.high for one in value))
    if declaration.choices:
        return isinstance(value, str) and value in declaration.choices
    if isinstance(declaration.default, bool):
        return isinstance(value, bool)
    kinds = int if isinstance(declaration.default, int) else (int, float)
    return (isinstance(value, kinds) and not isinstance(value, bool)
            and declaration.low <= value <= declaration.high)


def is_affordable(values):
    """Return whether a run with the values that would be taken stays short."""
    return all(values[name] <= most for name, most in AFFORDABLE.items()
               if name in values and accepts(name, values[name]))


def mostly(usual, rare):
    """Draw from the rare once in six times; one_of would count every branch within them alike."""
    return st.integers(0, 5).flatmap(lambda n: rare if n == 5 else usual)


RIGHT = st.sampled_from(sorted(DECLARATIONS)).flatmap(
    lambda name: st.tuples(st.just(name), right(DECLARATIONS[name])))
WRONG = st.tuples(mostly(st.sampled_from(sorted(DECLARATIONS)), UNKNOWN), OTHERS)
GROUPS = st.lists(mostly(RIGHT, WRONG), min_size=1, max_size=4).map(dict).filter(is_affordable)
CALM = st.lists(st.floats(-200.0, 200.0), min_size=3, max_size=3)
WILD = st.one_of(st.lists(st.floats(), min_size=3, max_size=3),
                 st.lists(st.floats(-1.0, 1.0), max_size=4))
PASSED = st.one_of(st.floats(1e-5, 1.0), st.sampled_from([0.0, 1e-9, 0.03, 50.0, 3500.0, -1.0]))
FRAMES = st.tuples(PASSED, mostly(CALM, WILD), mostly(st.just({}), GROUPS))
EVENTS = st.lists(st.one_of(GROUPS, FRAMES, FRAMES), min_size=8, max_size=20)


def stand_together(node, values):
    """Return whether values, each right, make a flag together (rules: test_physics_refusals)."""
    try:
        node.check(values)
    except ValueError:
        return False
    return True


def assert_set(bench, values):
    """Set a group of parameters: all of them count, or none and the reason is told."""
    node = bench.node
    before = dict(node.values)
    is_good = (all(accepts(name, value) for name, value in values.items())
               and stand_together(node, {**before, **values}))
    result = bench.put(**values)
    assert result.successful == is_good
    if is_good:
        before.update(values)
    else:
        assert result.reason
    before = plain(before)
    assert plain(node.values) == before
    assert plain({name: node.get_parameter(name).value for name in DECLARATIONS}) == before


def plain(values):
    """Return values with lists for all that hold several."""
    return {name: list(value) if hasattr(value, '__len__') and not isinstance(value, str)
            else value for name, value in values.items()}


def assert_frame(bench, time, wind, keyed, held):
    """
    Play a frame: a good one is answered, in bounds and finite; a bad one is refused.

    held: values of the last good frame, or None. Returns those of the last good one now.
    """
    message = bench.message(time, [0.0] * 3)
    message.changed_parameters = list(message.changed_parameters) + [
        to_parameter(f'physics.{name}', value).to_parameter_msg()
        for name, value in keyed.items()]
    wind_of = next(p for p in message.changed_parameters if p.name == 'wind')
    wind_of.value = to_parameter('wind', wind, float).to_parameter_msg().value
    cloud = bench.hear(message)
    is_good = (len(wind) == 3 and all(abs(w) <= 1e4 for w in wind)
               and all(accepts(name, value) for name, value in keyed.items()))
    assert (cloud is not None) == is_good
    if not is_good:
        return held
    values = {**bench.node.values, **keyed}
    if not stand_together(bench.node, values):  # then those of the frame before hold on
        values = held or dict(bench.node.values)
    positions, normals = messages.read_cloud(cloud)  # refuses what is not finite
    assert positions.shape == (values['grid.rows'], values['grid.columns'], 3)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0, atol=1e-6)
    length = values['flag.length'] or 1.5 * (values['flag.width'] or values['pole.height'] / 6.0)
    reach = np.linalg.norm(positions - positions[:, :1], axis=-1)
    allowed = (1.0 + values['stretch_limit']) * np.linspace(0.0, length, positions.shape[1])
    # Both ends were rounded to float32, each by half a unit in the last place of a coordinate.
    rounding = 2.0 * math.sqrt(3.0) * np.spacing(np.float32(np.abs(positions).max()))
    assert np.all(reach <= allowed * (1.0 + 1e-9) + rounding)
    return values


@pytest.fixture
def ros(domain):
    """Start ROS, once for all examples."""
    with rclpy.init(domain_id=domain):
        yield


@pytest.mark.parametrize('solver', DECLARATIONS['solver'].choices)
@settings(deadline=None, derandomize=True, database=None, max_examples=40 if SOAK else 12,
          phases=[Phase.generate, Phase.shrink],
          suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(events=EVENTS)
def test_random_parameters_and_frames_keep_the_node_alive_and_in_bounds(ros, solver, events):
    """Right and wrong values, alone and in groups, set and keyed, with any wind and any time."""
    bench = Bench()
    try:
        assert_set(bench, {'solver': solver, 'grid.rows': 5, 'grid.columns': 6,
                           'substeps_limit': 20})
        time, held = 0.0, None
        for event in events:
            if isinstance(event, dict):
                assert_set(bench, event)
            else:
                passed, wind, keyed = event
                time = max(time + passed, 0.0)
                held = assert_frame(bench, time, wind, keyed, held)
    finally:
        bench.close()
