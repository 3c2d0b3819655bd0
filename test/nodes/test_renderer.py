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

"""The renderer node, alone: odd clouds and parameters end in a right picture or a refusal."""
import itertools
import math
import time

from flag_sim.declarations.factories import look_of
from flag_sim.declarations.nodes import NODES
from flag_sim.drawing import Camera, Picture
from flag_sim.nodes import renderer
from flag_sim.ros import messages
from flag_sim.ros.parameter_node import to_parameter
from flag_sim.ros.topics import publish, subscribe
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import PointField
from support.flags import wave
from support.watch import PATIENCE


class Stand:
    """A renderer and somebody who sends it clouds and listens to all of its camera."""

    def __init__(self, domain):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        # The node uses the default context, which a test must leave as it found it.
        rclpy.init(domain_id=domain)
        self.renderer = renderer.Renderer()
        self.refused, self.frames = [], {}
        self.renderer.refuse = lambda topic, error: self.refused.append(str(error))
        self.other = Node('other', context=self.context)
        self.out = publish(self.other, 'vertices')
        for name in ('image_raw', 'camera_info', 'depth/image_raw'):
            subscribe(self.other, f'camera/{name}', self._keeper(name))
        self._stamps = itertools.count(1)
        self._executors = []
        for node, context in ((self.renderer, rclpy.get_default_context()),
                              (self.other, self.context)):
            executor = SingleThreadedExecutor(context=context)
            executor.add_node(node)
            self._executors.append(executor)
        self.spin(lambda: self.out.get_subscription_count() == 1
                  and len(self.renderer._listened()) == 3)
        # Without a wind, clouds are drawn once the renderer has given up to wait for one.
        time.sleep(renderer.WIND_DISCOVERY_TIME)

    def _keeper(self, name):
        def keep(message):
            stamp = messages.to_stamp(message.header.stamp)
            self.frames.setdefault(stamp, {})[name] = message
        return keep

    def spin(self, is_done):
        """Let both nodes work until `is_done`."""
        end = time.monotonic() + PATIENCE
        while not is_done():
            assert time.monotonic() < end, f'nothing came; refused: {self.refused}'
            for executor in self._executors:
                executor.spin_once(timeout_sec=0.01)

    def put(self, **values):
        """Set parameters of the renderer, `__` for a dot; the others are as born."""
        born = {one.name: one.default for one in NODES['renderer'] if not one.fixed}
        values = {**born, **{name.replace('__', '.'): value for name, value in values.items()}}
        return self.renderer.set_parameters_atomically(
            [to_parameter(name, value) for name, value in values.items()])

    def send(self, message):
        """Send a cloud under a new stamp, which is returned."""
        stamp = next(self._stamps) * 10 ** 7
        message.header.stamp = messages.to_time(stamp)
        self.refused.clear()
        self.out.publish(message)
        return stamp

    def film(self, message):
        """Return image, camera info and depth of a cloud."""
        stamp = self.send(message)
        self.spin(lambda: len(self.frames.get(stamp, ())) == 3)
        frame = self.frames.pop(stamp)
        info = frame['camera_info']
        rgb = np.frombuffer(frame['image_raw'].data, np.uint8).reshape(info.height, info.width, 3)
        depth = np.frombuffer(frame['depth/image_raw'].data, np.float32).reshape(rgb.shape[:2])
        return rgb, info, depth

    def expected(self, positions, normals=None):
        """Draw the same without the node."""
        look = look_of(self.renderer.values)
        frame = Picture().draw(np.float32(positions), normals, *look, ['depth'])
        return frame.colour, frame.depth

    def close(self):
        """End both nodes."""
        for node in (self.renderer, self.other):
            node.destroy_node()
        rclpy.shutdown()
        self.context.shutdown()


@pytest.fixture(scope='module')
def stand(module_domain):
    """Return a renderer that all tests of this module share: it must outlive each of them."""
    made = Stand(module_domain)
    yield made
    made.close()


@pytest.fixture
def small(stand):
    """Return the renderer with a small image and else default parameters."""
    assert stand.put(width=64, height=48).successful
    return stand


def cloud(positions, is_bigendian=False, padding=0, names='xyz'):
    """Make a cloud of positions alone, of a byte order, with bytes around points and rows."""
    rows, columns = positions.shape[:2]
    message = messages.cloud_message(0, positions, positions)
    message.fields = [PointField(name=name, offset=padding + 4 * i, count=1,
                                 datatype=PointField.FLOAT32) for i, name in enumerate(names)]
    message.is_bigendian = is_bigendian
    message.point_step = 12 + 2 * padding
    message.row_step = columns * message.point_step + padding
    data = np.zeros((rows, message.row_step), np.uint8)
    points = np.zeros((rows, columns, message.point_step), np.uint8)
    points[..., padding:padding + 12] = positions.astype('>f4' if is_bigendian else '<f4').view(
        np.uint8)
    data[:, :columns * message.point_step] = points.reshape(rows, -1)
    message.data = data.tobytes()
    return message


@pytest.mark.parametrize('layout', [
    {}, {'is_bigendian': True}, {'padding': 5}, {'is_bigendian': True, 'padding': 4}])
@pytest.mark.parametrize('rows, columns', [(5, 7), (9, 4), (2, 2)])
def test_any_cloud_is_drawn(small, layout, rows, columns):
    """Another grid in each frame, no normals, another byte order, padding: the same picture."""
    rgb, _, depth = small.film(cloud(wave(rows, columns), **layout))
    expected, expected_depth = small.expected(wave(rows, columns))
    np.testing.assert_array_equal(rgb, expected)
    np.testing.assert_array_equal(depth, expected_depth)
    assert np.isfinite(depth).any()


def spoil_point(message):
    """Put a NaN into a cloud's points."""
    points = np.frombuffer(message.data, np.float32).copy()
    points[7] = math.nan
    message.data = points.tobytes()


@pytest.mark.parametrize('spoil, said', [
    (lambda m: setattr(m, 'point_step', 4), 'point_step 4'),
    (lambda m: setattr(m, 'point_step', 400), 'row_step'),
    (lambda m: setattr(m, 'row_step', 10 ** 6), 'bytes of data'),
    (lambda m: setattr(m, 'width', 1), 'at least 2 x 2'),
    (lambda m: setattr(m, 'data', b''), '0 bytes of data'),
    (lambda m: setattr(m.fields[2], 'name', 'w'), "no field 'z'"),
    (spoil_point, 'nan'),
])
def test_a_spoilt_cloud_is_refused_and_the_next_one_drawn(small, spoil, said):
    """The rule and the value are told, and the node lives."""
    message = cloud(wave(5, 7))
    spoil(message)
    small.send(message)
    small.spin(lambda: small.refused)
    assert said in small.refused[0]
    rgb, _, _ = small.film(cloud(wave(5, 7)))
    np.testing.assert_array_equal(rgb, small.expected(wave(5, 7))[0])


@pytest.mark.parametrize('width, height', [(1, 1), (1, 50), (50, 1), (7680, 4320)])
def test_image_sizes(stand, width, height):
    """Each size gives images, depth and camera info of that size."""
    assert stand.put(width=width, height=height, camera__distance=3.0,
                     camera__target=[1.2, 0.3, 8.0]).successful
    rgb, info, depth = stand.film(cloud(wave(5, 7)))
    assert (info.width, info.height) == (width, height)
    expected, expected_depth = stand.expected(wave(5, 7))
    np.testing.assert_array_equal(rgb, expected)
    np.testing.assert_array_equal(depth, expected_depth)
    assert np.isfinite(depth[height // 2, width // 2])


@pytest.mark.parametrize('values', [
    {'camera__distance': 0.0, 'camera__target': [1.2, 0.45, 8.2]},
    {'camera__elevation': math.pi / 2}, {'camera__elevation': -math.pi / 2},
    {'camera__distance': 0.0}, {'sun__elevation': -0.5},
    {'camera__projection': 'orthographic', 'camera__distance': 0.0},
    {'camera__vertical_fov': 1.1}, {'camera__projection': 'orthographic', 'camera__scale': 5.0}])
def test_odd_views_are_drawn(small, values):
    """A camera in the cloth, straight up or down, at distance 0; a sun below the ground."""
    assert small.put(width=64, height=48, **values).successful
    rgb, info, _ = small.film(cloud(wave(5, 7)))
    np.testing.assert_array_equal(rgb, small.expected(wave(5, 7))[0])
    camera = look_of(small.renderer.values)[0]
    np.testing.assert_array_equal(info.k, camera.K.ravel())
    np.testing.assert_array_equal(info.p, camera.P.ravel())


def test_nan_and_infinite_numbers_are_refused(small):
    """Each parameter of the node that holds numbers refuses NaN and infinity."""
    for declaration in NODES['renderer']:
        if isinstance(declaration.default, (str, bool)) or declaration.fixed:
            continue
        for value in (math.nan, math.inf, -math.inf):
            result = small.renderer.set_parameters_atomically([to_parameter(
                declaration.name, [value] * (declaration.length or 3)
                if declaration.is_list else value)])
            assert not result.successful
            assert declaration.name in result.reason and str(value) in result.reason


@pytest.mark.parametrize('values', [
    {'flag__color': [0.0, 0.0, 256.0]}, {'background': [-1.0, 0.0, 0.0]},
    {'pole__color': [1.0, 2.0]}, {'platform__color': [math.nan, 0.0, 0.0]},
    {'width': 0}, {'height': 10 ** 6}, {'camera__distance': -1.0}])
def test_impossible_parameters_are_refused_and_the_old_ones_stay(small, values):
    """The reason names the parameter, and the picture is that of the parameters before."""
    before = small.film(cloud(wave(5, 7)))[0]
    result = small.put(**{'width': 64, 'height': 48, **values})
    assert not result.successful
    assert next(iter(values)).replace('__', '.') in result.reason
    np.testing.assert_array_equal(small.film(cloud(wave(5, 7)))[0], before)


def test_boxes_that_are_loaded_together_are_drawn(small):
    """One after another the lists would be refused, for they would not fit one another."""
    lists = {'objects.sizes': [0.5, 0.5, 0.5, 0.2, 0.2, 1.0],
             'objects.positions': [1.0, -1.0, 7.5, 1.5, -1.0, 7.5], 'objects.yaws': [0.5, 0.0]}
    [alone] = small.renderer.set_parameters([to_parameter(*next(iter(lists.items())))])
    assert not alone.successful
    assert 'objects.positions must be those of the 2 boxes' in alone.reason
    request = SetParameters.Request(parameters=[
        to_parameter(name, value).to_parameter_msg() for name, value in lists.items()])
    answer = small.renderer._parameter_service._set_parameters_callback(
        request, SetParameters.Response())
    assert all(result.successful for result in answer.results), answer.results
    plain = Picture().draw(np.float32(wave(5, 7)), None, Camera(64, 48)).colour
    found = small.film(cloud(wave(5, 7)))[0]
    np.testing.assert_array_equal(found, small.expected(wave(5, 7))[0])
    assert (found != plain).any(axis=-1).sum() > 30
