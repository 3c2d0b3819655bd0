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

"""The lines below the picture: frames a second, where the shot is, how long each node takes."""
from flag_sim.viewer.frame_counter import FrameCounter
from flag_sim.viewer.graph_model import GraphModel, ROLES

COMPUTE_TIME = 'compute time per frame'
"""How the entry of `state` begins that says how long a frame takes."""


def frame_words(counter: FrameCounter, now: float) -> str:
    """Return where the shot is and how fast it is shown at steady time `now` [s]."""
    if counter.stamp is None:
        return 'no picture yet'
    words = [f'{counter.rate(now):.1f} frames/s', f'stamp {counter.stamp / 1e9:.3f} s']
    if counter.place is not None:
        words.insert(1, f'frame {counter.place.index}')
        words.append(f'{counter.skipped} frames not shown')
    return ' \u00b7 '.join(words)


def compute_words(model: GraphModel) -> str:
    """Return how many milliseconds each node takes a frame, as it says itself on `state`."""
    words = []
    for role in ROLES:
        report = model.report(role)
        if report is None:
            continue
        time = next((value for key, value in report.values.items()
                     if key.startswith(COMPUTE_TIME)), None)
        try:
            words.append(f'{role} {float(time):.2f} ms')
        except (TypeError, ValueError):
            words.append(f'{role} {time}' if time else role)
    return ' \u00b7 '.join(words) or 'no node tells of itself on state yet'
