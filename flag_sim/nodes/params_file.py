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

"""Parameters as a params file, written whole or not at all."""
import os
import tempfile

from flag_sim import checks
import yaml


def check_path(path):
    """Raise ValueError if a file could not be written at `path`."""
    path = checks.path('save_to', path)
    folder = path.resolve().parent
    if not folder.is_dir():
        raise ValueError(f'save_to: there is no folder {folder}')
    if path.is_dir():
        raise ValueError(f'save_to: {path} is a folder')
    try:  # not by os.access: root may write to folders in which no file can be made
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ValueError(f'save_to: {path} cannot be written: {error.strerror}') from None


def save_parameters(path, node, values):
    """
    Write {name: value} as the params file of `node`, as `ros2 param dump` would.

    The file is written beside and then put in place, so a reader never sees half of it. Raises
    OSError where that fails; what was there before is then still there.
    """
    path = checks.path('save_to', path)
    content = yaml.safe_dump({node: {'ros__parameters': values}}, sort_keys=True)
    beside = path.with_name(f'.{path.name}-{os.getpid()}')
    try:
        beside.write_text(content)
        os.replace(beside, path)
    except OSError:
        beside.unlink(missing_ok=True)
        raise
