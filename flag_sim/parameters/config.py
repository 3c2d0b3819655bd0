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

"""Where the package's params files and the Fast DDS profile are."""
from pathlib import Path
import sys


def config_path(name: str) -> Path:
    """
    Return the path of a file in config/; raise FileNotFoundError that lists what is there.

    It is looked for beside the package (a source tree, also one installed as editable), then in
    share/flag_sim under each prefix: the folder that the package was installed to (colcon) and
    the Python installation (pip).
    """
    package = Path(__file__).resolve().parents[1]
    prefixes = [*package.parents, Path(sys.prefix)]
    folders = [package.parent / 'config',
               *(prefix / 'share' / 'flag_sim' / 'config' for prefix in prefixes)]
    present = [folder for folder in folders if (folder / 'fastdds.xml').is_file()]
    for folder in present:
        if (folder / name).is_file():
            return folder / name
    known = ', '.join(sorted(path.name for path in present[0].iterdir())) if present else 'none'
    raise FileNotFoundError(f"no file '{name}' in config/; there are: {known}")
