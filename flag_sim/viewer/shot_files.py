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

"""Params files as the window loads and saves them. No Qt."""
from collections.abc import Mapping
from pathlib import Path

from flag_sim.parameters.config import config_path
from flag_sim.parameters.file_targets import base_name, is_meant, keys_in, PARAMETERS
from flag_sim.parameters.params_file import save_parameters
import yaml

FILMED = ('pace', 'frames', 'window', 'wait_for', 'resend_after')
"""Of the wind: how a shot is filmed, and when it ends. They stay as they are while one looks."""


def read_sections(path: Path) -> dict[str, dict]:
    """
    Return {key of a node: {name: value}} of a params file, names with dots between their parts.

    Raises OSError, or ValueError for what is no params file.
    """
    keys_in(path)  # which says in words what is wrong with it
    sections = {}

    def walk(key, content):
        for name, inside in content.items():
            if name == PARAMETERS:
                sections.setdefault(key, {}).update(_flat(inside))
            elif isinstance(inside, dict):
                walk(f'{key}/{name}' if key else f'{name}', inside)
    walk('', yaml.safe_load(Path(path).read_text()) or {})
    return sections


def _flat(content, before=''):
    flat = {}
    if not isinstance(content or {}, dict):
        raise ValueError(f'{PARAMETERS} holds something else than names and values')
    for name, value in (content or {}).items():
        if isinstance(value, dict):
            flat.update(_flat(value, f'{before}{name}.'))
        else:
            flat[f'{before}{name}'] = value
    return flat


def values_for(sections: Mapping, node: str, role: str = '') -> dict[str, object]:
    """Return {name: value} of what a file has for a node: see meant_for."""
    return {name: value for values in meant_for(sections, node, role).values()
            for name, value in values.items()}


def meant_for(sections: Mapping, node: str, role: str = '') -> dict[str, dict]:
    """
    Return those sections of a file that are for the node of that full name.

    role: what it is in the graph, '' for what its name says. Where a file has nothing by its name,
    as for a renderer with one of its own, that is what is for a node that is called by its role.
    """
    known_as = f'{node.rpartition("/")[0]}/{role or base_name(node)}'
    if any(is_meant(key, node) and base_name(key) == base_name(node) for key in sections):
        known_as = node
    return {key: values for key, values in sections.items()
            if is_meant(key, node) or is_meant(key, known_as)}


def is_for_all(key: str) -> bool:
    """Return whether a section is for nodes of any name: some of them may lack a parameter."""
    return base_name(key) in ('*', '**')


def wind_values(values: Mapping) -> dict[str, object]:
    """
    Return what the window sets of a file's values for the wind.

    A shot, which says how many frames it has, brings all its tracks and events: those that were
    there before it are played no more. What says how it is filmed is left out.
    """
    nothing = {'tracks': [], 'events.names': [], 'events.times': []}
    values = {**nothing, **values} if 'frames' in values else values
    return {name: value for name, value in values.items() if name not in FILMED}


def shipped() -> dict[str, list[Path]]:
    """Return {'shots': paths, 'presets': paths} of the params files in config/."""
    found = {'shots': [], 'presets': []}
    try:
        folder = config_path('fastdds.xml').parent
    except FileNotFoundError:
        return found
    for path in sorted(folder.glob('*.yaml')):
        try:
            sections = read_sections(path)
        except (OSError, ValueError):
            continue
        is_shot = any('frames' in values for key, values in sections.items()
                      if key.endswith('wind'))
        found['shots' if is_shot else 'presets'].append(path)
    return found


def comment_of(path: Path) -> str:
    """Return what the comment at the beginning of a file says."""
    lines = []
    for line in path.read_text().splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines)


def save(path: Path, nodes: Mapping[str, Mapping]) -> None:
    """
    Write {full name of a node: {name: value}} as a params file, the first node's first.

    Raises OSError, or ValueError for a path at which something else stands.
    """
    (first, values), *others = nodes.items()
    try:
        save_parameters(path, first, values, dict(others))
    except ValueError as error:
        raise ValueError(str(error).removeprefix('save_to: ')) from None
