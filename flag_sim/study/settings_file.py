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

"""Settings from a params file of the nodes, and back into a new one."""
import os
from pathlib import Path

from flag_sim.declarations.factories import cloth_of, look_of
from flag_sim.declarations.nodes import named
from flag_sim.declarations.scene import check_scene
from flag_sim.parameters import checks
from flag_sim.parameters.file_targets import LARGEST
from flag_sim.parameters.plain_file import opened
from flag_sim.study.measures.settings import changed, DEFAULTS, defaults, Settings

# Parameters that have another name in settings, because two nodes have one of their name.
RENAMED = {('renderer', 'threads'): 'drawing.threads'}


def read(path: Path) -> tuple[Settings, list[str]]:
    """
    Return the settings that a params file gives the nodes, and the names that it does not know.

    Raises ValueError for what is no params file, and for values that a node would refuse or that
    make no flag and no picture together.
    """
    content = _content(checks.path('params file', path))
    changes, others = {}, []
    for place, block in content.items():
        if not isinstance(block, dict) or not isinstance(block.get('ros__parameters'), dict):
            raise ValueError(f'{path} is not a params file: {place} has no ros__parameters')
        node = str(place).rpartition('/')[2]
        nodes = DEFAULTS if node == '**' else [node]
        for name, value in _flat(block['ros__parameters']):
            own = RENAMED.get((node, name), name)
            declared = [named(one)[name] for one in nodes if own in DEFAULTS.get(one, {})]
            if declared:
                changes[own] = _accepted(path, declared[0], value)
            else:
                others.append(f'{node}.{name}')
    settings = changed(defaults(), changes)
    try:
        check_scene(settings)
        cloth_of(settings)
        look_of(settings)
    except ValueError as error:
        raise ValueError(f'{path}: {error}') from None
    return settings, others


def _content(path):
    """Return what is in a params file: a dict; raises ValueError."""
    import yaml
    try:
        with opened(path, LARGEST) as file:
            content = yaml.safe_load(file)
    except OSError as error:
        raise ValueError(f'{path} cannot be read: {error.strerror}') from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError):
        raise ValueError(f'{path} is not YAML') from None
    if not isinstance(content, dict):
        raise ValueError(f'{path} is not a params file')
    return content


def _accepted(path, declaration, value):
    """Return a value of a params file as settings have it; raises ValueError with the path."""
    try:
        accepted = declaration.accept(value)
    except ValueError as error:
        raise ValueError(f'{path}: {error}') from None
    return tuple(accepted) if declaration.is_list else accepted


def _flat(block, prefix=''):
    """Yield (dotted name, value) of a block that may be nested."""
    for name, value in block.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{prefix}{name}.')
        else:
            yield prefix + str(name), value


def by_node(settings: Settings, chosen: Settings) -> dict[str, Settings]:
    """Return {node: {parameter: value}} of the chosen ones, and of others than the default."""
    names = {own: name for (_, name), own in RENAMED.items()}
    found = {node: {names.get(name, name): _typed(settings[name], default)
                    for name, default in defaults_of_node.items()
                    if name in chosen or settings[name] != default}
             for node, defaults_of_node in DEFAULTS.items()}
    return {node: values for node, values in found.items() if values}


def _typed(value, default):
    """Return a value as its parameter's type, to 7 digits: people write 6 for 6.0."""
    if isinstance(default, tuple):
        return [_typed(*pair) for pair in zip(value, default)]
    return float(f'{value:.7g}') if isinstance(default, float) else type(default)(value)


def check_new(path: Path) -> Path:
    """Return `path`; raise ValueError unless a new file can be written there."""
    path = checks.path('output', path)
    folder = path.resolve().parent
    for is_wrong, words in ((path.exists(), f' {path} exists; it is not overwritten'),
                            (not folder.is_dir(), f': there is no folder {folder}'),
                            (not os.access(folder, os.W_OK),
                             f': the folder {folder} cannot be written')):
        if is_wrong:
            raise ValueError(f'output{words}')
    return path


def write(path: Path, comment: list[str], values: dict[str, Settings], folder: Path) -> None:
    """
    Write {node: {parameter: value}} as a params file with lines of comment, whole or not at all.

    folder: of the same file system, where it is written first. Raises FileExistsError if the file
    exists.
    """
    import yaml
    lines = [f'# {line}'.rstrip() + '\n' for line in comment]
    content = {f'/**/{node}': {'ros__parameters': own}  # in any namespace
               for node, own in values.items()}
    unfinished = folder / 'params.yaml'
    unfinished.write_text(''.join(lines) + yaml.safe_dump(content, sort_keys=False))
    os.link(unfinished, path)
