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

"""A small shot, and what its bag holds."""
from pathlib import Path

from rosbags.highlevel import AnyReader

# Small pictures: the tests look at what arrives, not at how fast.
SMALL = ('-p', 'width:=160', '-p', 'height:=120')
SHOT = ('-p', 'pace:=lockstep', '-p', 'rate:=30.0', '-p', 'speed:=9.0',
        '-p', 'tracks:=[physics.stiffness, renderer.sun.elevation]',
        '-p', 'keys.physics.stiffness.times:=[0.0, 0.5]',
        '-p', 'keys.physics.stiffness.values:=[500.0, 2000.0]',
        '-p', 'keys.renderer.sun.elevation.times:=[0.0, 1.0]',
        '-p', 'keys.renderer.sun.elevation.values:=[0.2, 1.2]')


def film(graph, bag, frames, *, seconds=90.0, extra=None):
    """Play the small shot through `graph` into `bag`; return the exit status of the wind."""
    extra = extra or {}
    graph.start('physics', *extra.get('physics', ()))
    graph.start('renderer', *SMALL, *extra.get('renderer', ()))
    graph.start('recorder', '-p', f'path:={bag}', '-p', f'frames:={frames}',
                *extra.get('recorder', ()))
    graph.start('wind', *SHOT, '-p', f'frames:={frames}', '-p', 'wait_for:=[renderer, recorder]',
                *extra.get('wind', ()))
    status = graph.wait('wind', seconds)
    graph.wait('recorder', 90.0)
    return status


def messages_of(bag, topic):
    """Return [(time in the bag [ns], message)] of a topic, in the order of reading."""
    with AnyReader([Path(bag)]) as reader:
        connections = [c for c in reader.connections if c.topic == topic]
        return [(time, reader.deserialize(data, connection.msgtype))
                for connection, time, data in reader.messages(connections)]


def stamp_of(message):
    """Return the stamp of a message with a header [ns]."""
    stamp = message.header.stamp
    return stamp.sec * 10**9 + stamp.nanosec
