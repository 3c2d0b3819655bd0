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

"""Hostile inputs: sets of parameters, mostly right ones, and messages, crafted or mutilated."""
from flag_sim.declarations.nodes import NODES
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from hypothesis import strategies as st
import numpy as np
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterType, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Empty, Header
from support.frames import parameters_message

AFFORDABLE = {'grid.rows': 12, 'grid.columns': 12, 'substeps': 20, 'substeps_limit': 20,
              'width': 64, 'height': 48, 'preroll': 0.1, 'threads': 2, 'max_gap': 2.0}
"""Greatest right values drawn, so that an example is over in milliseconds."""
AS_IT_IS = ('solver', 'precision', 'save_to', 'path', 'use_sim_time')
"""Of these no other right value is drawn: kernels would be compiled, or files written."""
INTEGERS = st.integers(-2**63, 2**63 - 1)
NUMBERS = st.one_of(st.floats(), st.sampled_from([0.0, -1.0, 1e308, 5e-324, 1e12, np.pi]))
TEXTS = st.one_of(st.text(max_size=8), st.sampled_from(
    ['', 'renderer', 'a\nb', '\x1b[31m', 'x' * 5000, '/etc/passwd', '~nobody/x', 'é', '..']))
VALUES = st.builds(
    ParameterValue, type=st.one_of(st.integers(0, 12), st.integers(0, 255)),
    bool_value=st.booleans(), integer_value=INTEGERS, double_value=NUMBERS, string_value=TEXTS,
    byte_array_value=st.lists(st.binary(min_size=1, max_size=1), max_size=3),
    bool_array_value=st.lists(st.booleans(), max_size=3),
    integer_array_value=st.lists(INTEGERS, max_size=3),
    double_array_value=st.lists(NUMBERS, max_size=4),
    string_array_value=st.lists(TEXTS, max_size=3))
TRACKS = ['wind.speed', 'wind.azimuth', 'physics.gravity', 'physics.pole_collision',
          'renderer.width', 'renderer.background', 'physics.colour', 'moon.phase']
TIMES = st.lists(st.integers(0, 20), min_size=1, max_size=4, unique=True).map(
    lambda times: [0.1 * time for time in sorted(times)])


def _value(kind, value):
    """Return a ParameterValue of a type by the name of its field."""
    return ParameterValue(type=getattr(ParameterType, f'PARAMETER_{kind.upper()}'),
                          **{f'{kind}_value': value})


def _single(declaration):
    """Return the strategy of a right single value, or of an item of a right list."""
    if declaration.choices:
        return st.sampled_from(declaration.choices)
    if declaration.kind is bool:
        return st.booleans()
    if declaration.kind is str:
        return TEXTS
    low = -1e6 if declaration.low is None else declaration.low
    high = 1e6 if declaration.high is None else declaration.high
    high = min(high, AFFORDABLE.get(declaration.name, high))
    numbers = st.integers if declaration.kind is int else st.floats
    return st.one_of(numbers(low, high), st.sampled_from([low, high]))


def _right(declaration):
    """Return the strategy of a ParameterValue that the declaration takes."""
    kind = {bool: 'bool', int: 'integer', float: 'double', str: 'string'}[declaration.kind]
    if declaration.name in AS_IT_IS:
        return st.just(_value('string', declaration.default))
    single = _single(declaration)
    if not declaration.is_list:
        return single.map(lambda value: _value(kind, value))
    length = declaration.length
    return st.lists(single, min_size=length or 0, max_size=length or 3).map(
        lambda value: _value(f'{kind}_array', value))


def _keys():
    """Return the strategy of a parameter that holds a part of a track's keys."""
    return st.one_of(
        st.builds(lambda track, times: Parameter(
            name=f'keys.{track}.times', value=_value('double_array', times)),
            st.sampled_from(TRACKS), TIMES),
        st.builds(lambda track, values: Parameter(
            name=f'keys.{track}.values', value=_value('double_array', values)),
            st.sampled_from(TRACKS), st.lists(st.floats(0.0, 40.0), max_size=4)),
        st.builds(lambda track, laws: Parameter(
            name=f'keys.{track}.laws', value=_value('string_array', laws)),
            st.sampled_from(TRACKS),
            st.lists(st.sampled_from(['step', 'linear', 'cubic', 'ease', 'x']), max_size=4)),
        st.builds(lambda tracks: Parameter(
            name='tracks', value=_value('string_array', tracks)),
            st.lists(st.sampled_from(TRACKS[:5]), max_size=2)),
        st.builds(lambda track, part, value: Parameter(name=f'keys.{track}.{part}', value=value),
                  st.sampled_from(TRACKS), st.sampled_from(['times', 'values', 'laws', 'turns']),
                  VALUES))


def parameters_of(name):
    """Return the strategy of up to ten parameters for a node, most of them right."""
    right = st.one_of(*(
        _right(one).map(lambda value, own=one.name: Parameter(name=own, value=value))
        for one in NODES[name]))
    names = st.one_of(TEXTS, st.sampled_from(
        [one.name for one in NODES[name] if one.name not in AS_IT_IS]
        + ['use_sim_time', 'qos_overrides./parameters.publisher.depth']))
    wrong = st.builds(Parameter, name=names, value=VALUES)
    kinds = [right] * 4 + [wrong] + [_keys()] * (2 * (name == 'wind'))
    return st.lists(st.integers(0, len(kinds) - 1).flatmap(kinds.__getitem__), min_size=1,
                    max_size=10)


# Messages.

STAMPS = st.one_of(st.integers(0, 3 * 10**9), st.sampled_from(
    [0, messages.LATEST, messages.LATEST - 1, -1, -2**31 * 10**9]))
INDICES = st.one_of(st.integers(0, 12), st.sampled_from([-1, 2**63 - 1, -2**63, 100]))


def _headers():
    return st.builds(Header, stamp=STAMPS.map(messages.to_time), frame_id=st.one_of(
        TEXTS, st.sampled_from(['renderer', 'recorder'])))


def _frames():
    """Return the strategy of `parameters` messages, right ones and others."""
    def right(stamp, take, index, behind, wind):
        return parameters_message('/wind', FrameId(
            stamp, take, index, max(index - behind, -2**63)), wind, {})
    finite = st.lists(st.floats(-30.0, 30.0), min_size=3, max_size=3)
    winds = st.one_of(finite, finite, st.lists(NUMBERS, min_size=3, max_size=3))
    names = st.sampled_from(['wind', 'frame.take', 'frame.index', 'frame.oldest',
                             'physics.stiffness', 'renderer.width', 'physics.x', ''])
    event = st.builds(
        ParameterEvent, node=st.sampled_from(['/wind', '/physics', '/renderer', '', 'x\ny']),
        stamp=STAMPS.map(messages.to_time), changed_parameters=st.lists(
            st.builds(Parameter, name=names, value=VALUES), max_size=5))
    order = st.builds(right, STAMPS, INDICES, INDICES, st.integers(0, 3), winds)
    return st.one_of(order, order, event)


def _clouds():
    def cloud(stamp, rows, columns, spoil, value):
        points = np.random.default_rng(rows).normal(size=(rows, columns, 3))
        message = messages.cloud_message(stamp, points, points)
        if spoil == 'data':
            message.data = message.data[:int(abs(value)) % 97]
        elif spoil == 'fields':
            message.fields = [PointField(name='x', datatype=int(abs(value)) % 12)] * 3
        elif spoil in ('height', 'width', 'point_step', 'row_step'):
            setattr(message, spoil, int(abs(value)) % 2**32)
        return message
    spoils = st.sampled_from(['', '', '', 'data', 'fields', 'height', 'width', 'point_step',
                              'row_step'])
    return st.builds(cloud, STAMPS, st.integers(2, 5), st.integers(2, 5), spoils, st.one_of(
        st.integers(0, 40), st.integers(0, 2**32 - 1)))


MESSAGES = {ParameterEvent: _frames(), PointCloud2: _clouds(), Header: _headers(),
            Empty: st.just(Empty())}
"""The strategy of messages by their type."""


def mutilated(type_, message, changes):
    """
    Return a message of which bytes were changed on the way, or None where it cannot be read.

    changes: [(place as a part of its length, byte)], applied in turn.
    """
    data = bytearray(serialize_message(message))
    for part, byte in changes:
        data[4 + int(part * (len(data) - 4))] = byte  # not in what says how it is encoded
    try:
        return deserialize_message(bytes(data), type_)
    except Exception:  # the middleware would not have handed it over
        return None


CHANGES = st.lists(st.tuples(st.floats(0.0, 0.999), st.integers(0, 255)), min_size=1, max_size=4)
