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

"""
What a frame of a large animation costs the wind node: 10,000 keys in 50 tracks.

Measures the node's work for a frame: the values of all tracks, the wind with gusts, the crossed
keys and the message, and beside it the message's publication. Medians, written to
out/bench-animation.json.
"""
import argparse
import json
from pathlib import Path
import statistics
import time

from flag_sim.animation import keys
from flag_sim.animation.wind_source import WindSource
from flag_sim.declarations.keyable import TARGETS
from flag_sim.declarations.nodes import defaults, NODES
from flag_sim.parameters.arguments import given_path
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import frame_message
from flag_sim.ros.topics import publish
import numpy as np
import rclpy
from rclpy.node import Node

TRACKS, KEYS = 50, 200  # of each track
FRAMES = 2000
LAWS = ('linear', 'ease', 'cubic', 'step')


def animation():
    """Return the wind's values with keys for the first tracks that can be keyed."""
    values = defaults('wind')
    values.update({'tracks': [], 'gust.intensity': 0.2})
    source = np.random.default_rng(1)
    times = np.cumsum(source.uniform(0.1, 0.5, KEYS)).tolist()
    for node in ('renderer', 'physics', 'wind'):
        for declaration in NODES[node]:
            name = f'{node}.{declaration.name}'
            if len(values['tracks']) == TRACKS or not is_number(name):
                continue
            low, high = max(declaration.low, -100.0), min(declaration.high, 100.0)
            keyed = source.uniform(low, high, KEYS * (declaration.length or 1))
            if isinstance(declaration.default, int):
                keyed = np.round(keyed)
            values['tracks'].append(name)
            values[keys.key_name(name, 'times')] = times
            values[keys.key_name(name, 'values')] = keyed.tolist()
            values[keys.key_name(name, 'laws')] = [LAWS[k % len(LAWS)] for k in range(KEYS)]
    assert len(values['tracks']) == TRACKS
    return values, times[-1]


def is_number(track):
    """Return whether a track can be made of a parameter, and interpolates."""
    try:
        return TARGETS[track].declaration.low is not None
    except ValueError:
        return False


def median_ms(work, times):
    """Return the median milliseconds of work(time) over times."""
    spent = []
    for at in times:
        begin = time.perf_counter()
        work(at)
        spent.append(time.perf_counter() - begin)
    return 1e3 * statistics.median(spent)


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--quick', action='store_true', help='few frames')
    parser.add_argument('--out', type=given_path, default=Path('out/bench-animation.json'))
    options = parser.parse_args()
    frames = 20 if options.quick else FRAMES
    values, end = animation()
    timeline = keys.read_timeline(values, TARGETS)
    source = WindSource(values, timeline)
    times = np.linspace(0.0, end, frames).tolist()
    step = times[1]
    frame = FrameId(0, 1, 0, 0)
    keyed, wind = keys.values_at(timeline, 1.0, TARGETS), source.at(1.0)
    with rclpy.init():
        node = Node('benchmark')
        out = publish(node, 'parameters')
        message_of = frame_message.FrameMessage('/wind')
        message = message_of.fill(frame, wind, keyed)
        rows = {
            'values of the tracks': lambda at: keys.values_at(timeline, at, TARGETS),
            'wind with gusts': source.at,
            'crossed keys': lambda at: timeline.crossed(at - step, at),
            'message': lambda at: message_of.fill(frame, wind, keyed),
            'publication': lambda at: out.publish(message),
        }
        result = {what: round(median_ms(work, times), 4) for what, work in rows.items()}
    work = sum(spent for what, spent in result.items() if what != 'publication')
    for what, spent in {**result, 'work of the node (without publication)': work}.items():
        print(f'{what:40}{spent:8.3f} ms')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(result, indent=2) + '\n')
    print(f'{TRACKS * KEYS} keys in {TRACKS} tracks, medians of {frames} frames, '
          f'written to {options.out}')


if __name__ == '__main__':
    main()
