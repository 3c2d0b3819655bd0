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

"""Params files of the nodes: read for what a study depends on, and written."""
import os
from pathlib import Path
import tempfile

from flag_sim.parameters import checks
from flag_sim.study.measures.settings import changed, DEFAULTS, defaults, Settings

# Parameters that have another name in settings, because two nodes have one of their name.
OWN = {('renderer', 'threads'): 'drawing.threads'}


def read(path: Path) -> tuple[Settings, list[str]]:
    """
    Return the settings that a params file gives the nodes, and the names that it does not know.

    Raises ValueError for what is no params file.
    """
    import yaml
    try:
        content = yaml.safe_load(checks.path('params file', path).read_text())
    except OSError as error:
        raise ValueError(f'{path} cannot be read: {error.strerror}') from None
    except (yaml.YAMLError, UnicodeDecodeError):
        raise ValueError(f'{path} is not YAML') from None
    if not isinstance(content, dict):
        raise ValueError(f'{path} is not a params file')
    changes, others = {}, []
    for place, block in content.items():
        if not isinstance(block, dict) or not isinstance(block.get('ros__parameters'), dict):
            raise ValueError(f'{path} is not a params file: {place} has no ros__parameters')
        node = str(place).rpartition('/')[2]
        known = DEFAULTS.values() if node == '**' else [DEFAULTS.get(node, {})]
        for name, value in _flat(block['ros__parameters']):
            name = OWN.get((node, name), name)
            if any(name in names for names in known):
                changes[name] = value
            else:
                others.append(f'{node}.{name}')
    return changed(defaults(), changes), others


def _flat(block, prefix=''):
    """Yield (dotted name, value) of a block that may be nested."""
    for name, value in block.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{prefix}{name}.')
        else:
            yield prefix + str(name), value


def blocks(settings: Settings, chosen: Settings) -> dict[str, Settings]:
    """Return {node: {parameter: value}} of the chosen ones, and of others than the default."""
    names = {own: name for (_, name), own in OWN.items()}
    return {node: {names.get(name, name): _typed(settings[name], default)
                   for name, default in defaults_of_node.items()
                   if name in chosen or settings[name] != default}
            for node, defaults_of_node in DEFAULTS.items()}


def _typed(value, default):
    """Return a value as its parameter's type: people write 6 for 6.0."""
    if isinstance(default, tuple):
        return [_typed(*pair) for pair in zip(value, default)]
    return type(default)(value)


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


def write(path: Path, comment: list[str], blocks: dict[str, Settings]) -> None:
    """
    Write {node: {parameter: value}} as a params file with lines of comment, whole or not at all.

    Raises FileExistsError if the file exists.
    """
    lines = [f'# {line}'.rstrip() for line in comment]
    for node, values in blocks.items():
        if values:
            lines += [f'/**/{node}:', '  ros__parameters:']  # in any namespace
            lines += [f'    {name}: {_text(value)}' for name, value in values.items()]
    handle, beside = tempfile.mkstemp(dir=path.parent, prefix=f'.{path.name}-')
    try:
        with os.fdopen(handle, 'w') as file:
            file.write('\n'.join(lines) + '\n')
        os.chmod(beside, 0o644)
        os.link(beside, path)
    finally:
        os.unlink(beside)


def _text(value):
    """Return a value as YAML that ROS reads as its type: a float always with its point."""
    if isinstance(value, float):
        digits, letter, power = f'{value:.7g}'.partition('e')
        return digits + '.0' * ('.' not in digits) + letter + power
    if isinstance(value, list):
        return f'[{", ".join(map(_text, value))}]'
    return str(value).lower() if isinstance(value, bool) else str(value)
