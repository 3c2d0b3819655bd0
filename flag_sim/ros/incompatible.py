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

"""Incompatible quality of service: which topic it is, between whom, and what helps."""
from collections.abc import Callable

from flag_sim.ros.node_log import NodeLog
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import qos_check_compatible, qos_policy_name_from_kind, QoSCompatibility

OVERRIDDEN = ('history', 'depth', 'reliability')
"""Policies that a node's own topics take overrides of."""
NAMED_AFTER = 0.5
"""How long after an end its node's name may be known [s]; DDS tells them one after the other."""
UNKNOWN = '_NODE_NAME_UNKNOWN_'


def _telling(node: Node, name: str, end: str) -> Callable:
    """Return a callback that warns of who cannot be served; `end` is the node's own."""
    log = NodeLog(node)
    timers = []  # at most one: it tells of all who have come meanwhile

    def wait(event):
        if not timers:
            timers.append(node.create_timer(NAMED_AFTER, lambda: tell(event)))

    def tell(event):
        node.destroy_timer(timers.pop())
        topic = node.resolve_topic_name(name)
        policy = qos_policy_name_from_kind(event.last_policy_kind).lower()
        what = ('subscribes to it with a quality of service that this node does not offer, and '
                'receives nothing' if end == 'publisher' else
                'publishes it without the quality of service that this node needs, and is not '
                'heard')
        cure = f'give both the same {policy}'
        if policy in OVERRIDDEN:
            cure += f': this node by qos_overrides.{topic}.{end}.{policy}'
        log.warn(f'{topic}: {_others(node, topic, end) or "somebody"} {what}; {cure}', name)
    return wait


def _others(node, topic, end):
    """Return the names of the nodes at the other end that no end of ours fits."""
    publishers = node.get_publishers_info_by_topic(topic)
    subscriptions = node.get_subscriptions_info_by_topic(topic)
    own, others = ((publishers, subscriptions) if end == 'publisher' else
                   (subscriptions, publishers))
    own = [one for one in own if one.node_name == node.get_name()
           and one.node_namespace == node.get_namespace()]

    def fits(one, other):
        pair = (one, other) if end == 'publisher' else (other, one)
        found, _ = qos_check_compatible(*(each.qos_profile for each in pair))
        return found != QoSCompatibility.ERROR
    return ', '.join(sorted({other.node_name for other in others
                             if other.node_name != UNKNOWN
                             and not any(fits(one, other) for one in own)}))


def publisher_events(node: Node, name: str) -> PublisherEventCallbacks:
    """Return what a publisher of topic `name` says of subscriptions that it cannot serve."""
    return PublisherEventCallbacks(incompatible_qos=_telling(node, name, 'publisher'))


def subscription_events(node: Node, name: str) -> SubscriptionEventCallbacks:
    """Return what a subscription to topic `name` says of publishers that it cannot hear."""
    return SubscriptionEventCallbacks(incompatible_qos=_telling(node, name, 'subscription'))
