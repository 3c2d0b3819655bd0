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
Keyframes, and the wind that they play.

A key is a value at a time; a track is the keys of one value (Blender: F-curve; glTF: sampler); the
law of a segment is how the value goes from its key to the next (interpolation mode); a timeline
plays many tracks, once or in a loop. Built on one another: laws, tracks, timeline.
"""
