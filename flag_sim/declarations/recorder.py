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

"""Parameters of the recorder node."""
from flag_sim.parameters.declaration import Declaration

RECORDER = (
    Declaration('path', '', 'folder of the new bag; empty: rosbag2_ and the date', fixed=True),
    Declaration(
        'topics',
        ['camera/image_raw', 'camera/camera_info', 'vertices', 'parameters', 'keyframe'],
        'topics to record', item=str, fixed=True),
    Declaration('frames', 0, 'end with a take of so many frames; 0: when told to', 'frames',
                0, 2**31 - 1, fixed=True),
    Declaration('storage', 'mcap', 'file format', choices=('mcap', 'sqlite3'), fixed=True),
    Declaration('compression', 'none', 'compression of the file', choices=('none', 'zstd'),
                fixed=True),
)
