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

"""The topics: their names, types and quality of service."""
from collections.abc import Callable
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from flag_sim.ros.guard import GuardedPublisher
from flag_sim.ros.incompatible import publisher_events, subscription_events, UNKNOWN
from flag_sim.ros.parameter_node import BadParameter
from flag_sim.ros.qos_overrides import check_overrides
from geometry_msgs.msg import PoseStamped, Vector3Stamped, WrenchStamped
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2
from std_msgs.msg import Empty, Header
from visualization_msgs.msg import Marker

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # where it is not installed, nobody can listen either
    TFMessage = None


class Topic(NamedTuple):
    """
    A topic's message type.

    every_frame: whether every frame brings one message. stamped: whether the message begins with
    a time of the simulation, by which it can be recorded.
    """

    message: type
    every_frame: bool
    stamped: bool = True


TOPICS = {
    'parameters': Topic(ParameterEvent, True),
    'keyframe': Topic(Header, False),
    'wind': Topic(Vector3Stamped, True),
    '/clock': Topic(Clock, False),
    'vertices': Topic(PointCloud2, True),
    'pole_load': Topic(WrenchStamped, True),
    'camera/image_raw': Topic(Image, True),
    'camera/camera_info': Topic(CameraInfo, True),
    'camera/image_raw/compressed': Topic(CompressedImage, True),
    'camera/pose': Topic(PoseStamped, True),
    'camera/depth/image_raw': Topic(Image, True),
    'camera/depth/camera_info': Topic(CameraInfo, True),
    'camera/normals/image_raw': Topic(Image, True),
    'camera/labels/image_raw': Topic(Image, True),
    'camera/texture_coordinates/image_raw': Topic(Image, True),
    'camera/flow/image_raw': Topic(Image, True),
    'marker': Topic(Marker, True),
    'frame_done': Topic(Header, False),
    'reset': Topic(Empty, False, False),
    'step': Topic(Empty, False, False),
    'state': Topic(DiagnosticArray, False, False),
}
if TFMessage is not None:
    TOPICS['/tf'] = Topic(TFMessage, True, False)

DEPTH = 8
"""Messages in a queue: as many as wind's largest window has in flight, so lockstep fills none."""


def _quality(node, name, end):
    try:
        check_overrides(node, node.resolve_topic_name(name), end)
    except ValueError as error:
        raise BadParameter(str(error)) from None
    return {'qos_profile': QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE),
            'qos_overriding_options': QoSOverridingOptions.with_default_policies()}


def publish(node: Node, name: str) -> GuardedPublisher:
    """Return a publisher of topic `name` of `TOPICS` for `node`."""
    return GuardedPublisher(node, node.create_publisher(
        TOPICS[name].message, name, event_callbacks=publisher_events(node, name),
        **_quality(node, name, 'publisher')))


def publishers(node: Node, name: str) -> str:
    """Return the names of the nodes that publish a topic, as far as `node` knows, or ''."""
    ends = node.get_publishers_info_by_topic(node.resolve_topic_name(name))
    names = {end.node_name for end in ends}
    # DDS tells of an end before it tells whose it is.
    return ', '.join(sorted(names - {UNKNOWN})) or (ends and 'a node that is not known yet') or ''


def subscribers(node: Node, name: str) -> dict[str, bytes]:
    """Return {full name: GID of the endpoint} of the nodes that subscribe to a topic."""
    ends = node.get_subscriptions_info_by_topic(node.resolve_topic_name(name))
    return {f'{end.node_namespace.rstrip("/")}/{end.node_name}': bytes(end.endpoint_gid)
            for end in ends}


def subscribe(node: Node, name: str, callback: Callable, raw: bool = False) -> Subscription:
    """Subscribe `node` to topic `name` of `TOPICS`; raw: the callback gets serialised bytes."""
    return node.create_subscription(TOPICS[name].message, name, callback, raw=raw,
                                    event_callbacks=subscription_events(node, name),
                                    **_quality(node, name, 'subscription'))
