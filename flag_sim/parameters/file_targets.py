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

"""Which nodes a params file has parameters for."""
from collections.abc import Sequence
import re

PARAMETERS = 'ros__parameters'
"""The key under which a params file holds the parameters of a node."""


def given_files(arguments: Sequence[str]) -> list[str]:
    """Return the params files among a node's arguments."""
    return [after for before, after in zip(arguments, arguments[1:]) if before == '--params-file']


def is_meant(key: str, node: str) -> bool:
    """
    Return whether a params file's key is meant for the node of that full name.

    As rclpy has it: /** stands for any number of namespaces, /* for one.
    """
    pattern = key if key.startswith('/') else f'/{key}'
    pattern = pattern.replace('/**', r'(/\w+)@').replace('/*', r'(/\w+)').replace('@', '*')
    return re.fullmatch(pattern, node) is not None


def keys_of(content: object, prefix: str = '') -> list[str]:
    """
    Return the keys of the nodes that a params file has parameters for, as they are written.

    content: as YAML reads it; prefix: of the keys, where it is a part of a file.
    """
    if not isinstance(content, dict):
        return []
    keys = []
    for name, value in content.items():
        if name == PARAMETERS:
            keys.append(prefix)
        else:
            keys += keys_of(value, f'{prefix}/{name}' if prefix else str(name))
    return keys
