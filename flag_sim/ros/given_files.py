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

"""Params files that a node was given: whether anything in them is meant for it."""
from pathlib import Path
import re

import yaml


def given_files(arguments):
    """Return the params files among a node's arguments."""
    return [after for before, after in zip(arguments, arguments[1:]) if before == '--params-file']


def is_meant(key, node):
    """
    Return whether a params file's key is meant for the node of that full name.

    As rclpy has it: /** stands for any number of namespaces, /* for one.
    """
    pattern = key if key.startswith('/') else f'/{key}'
    pattern = pattern.replace('/**', r'(/\w+)@').replace('/*', r'(/\w+)').replace('@', '*')
    return re.fullmatch(pattern, node) is not None


def keys_of(content, prefix=''):
    """Return the names of the nodes that a params file has parameters for, as they are written."""
    if not isinstance(content, dict):
        return []
    keys = []
    for name, value in content.items():
        if name == 'ros__parameters':
            keys.append(prefix)
        else:
            keys += keys_of(value, f'{prefix}/{name}' if prefix else str(name))
    return keys


def tell_of_strangers(node, arguments):
    """Let the node say which of the params files in `arguments` mean it with no word."""
    name = node.get_fully_qualified_name()
    for path in given_files(arguments):
        keys = keys_of(yaml.safe_load(Path(path).read_text()))
        if any(is_meant(key, name) for key in keys):
            continue
        text = (f'nothing in {path} is meant for {name}; it has parameters for '
                f'{", ".join(keys) or "nobody"}')
        namesakes = [key for key in keys if key.rpartition('/')[2] == node.get_name()]
        if namesakes:  # it was meant, but in another namespace
            node.get_logger().warning(
                f'{text}: all of it is ignored. /**/{node.get_name()} instead of {namesakes[0]} '
                'counts in every namespace')
        else:
            node.get_logger().info(text)
