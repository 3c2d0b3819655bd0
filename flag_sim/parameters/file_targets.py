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
import os
import re

from flag_sim.parameters.plain_file import opened

PARAMETERS = 'ros__parameters'
"""The key under which a params file holds the parameters of a node."""
LARGEST = 64 << 20
"""Bytes of a params file: about two million keys of a track."""
DEEPEST = 64
"""Levels of a params file."""


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


def base_name(node: str) -> str:
    """Return the name of a node, or of a params file's key, without its namespace."""
    return node.rpartition('/')[2]


def keys_in(path: str | os.PathLike) -> list[str]:
    """
    Return the keys of the nodes that a params file has parameters for, as they are written.

    The file is read bit by bit, and nothing is made of it, so it may be anybody's. Raises
    ValueError for what is no params file, or a larger one than `LARGEST`, and OSError.
    """
    import yaml  # which the library does without
    with opened(path, LARGEST) as file:
        try:
            return _keys(yaml, yaml.parse(file, getattr(yaml, 'CSafeLoader', yaml.SafeLoader)))
        except yaml.YAMLError as error:
            # The library names an open file by its number.
            said = ' '.join(str(error).replace(f'in "{file.name}", ', 'in ').split())
            raise ValueError(f'{path} is not YAML: {said[:200]}') from None
        except ValueError as error:
            raise ValueError(f'{path} is not a params file: {error}') from None


def _keys(yaml, events):
    """Return the keys of the nodes among the events of a YAML parser."""
    keys = []
    names = []  # of the mappings that are open, None between two entries; False: in a list
    for event in events:
        if isinstance(event, yaml.AliasEvent):
            raise ValueError('it has an alias')
        if isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            names.pop()
        elif isinstance(event, yaml.NodeEvent):
            is_scalar = isinstance(event, yaml.ScalarEvent)
            is_mapping = isinstance(event, yaml.MappingStartEvent)
            if names and names[-1] is None:  # a key
                if not is_scalar:
                    raise ValueError('a key is not a text')
                names[-1] = event.value
                continue
            if PARAMETERS not in names and not is_mapping:
                raise ValueError('it holds something else than parameters of nodes')
            if names and names[-1] == PARAMETERS and PARAMETERS not in names[:-1]:
                keys.append('/'.join(names[:-1]))
            if not is_scalar:
                if len(names) == DEEPEST:
                    raise ValueError(f'it is more than {DEEPEST} levels deep')
                names.append(None if is_mapping else False)
                continue
        else:
            continue
        if names and isinstance(names[-1], str):  # its value is read
            names[-1] = None
    return keys
