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

"""YAML of which every value knows its line, so that what is refused can be found."""
import dataclasses

from flag_sim.parameters.plain_file import opened

LARGEST = 1 << 20
"""Bytes of a file."""
DEEPEST = 32
"""Levels of a file."""
TAGS = (None, 'tag:yaml.org,2002:map', 'tag:yaml.org,2002:seq')
"""What a list or entries may be marked as; YAML itself reads the tags of texts and numbers."""


class MarkedError(ValueError):
    """What a file says cannot be used; its message begins with the file's name and the line."""


@dataclasses.dataclass(frozen=True)
class Marked:
    """
    A value of a file: a dict {text: Marked}, a list of Marked, a text, a number, a bool or None.

    source: the file's name; line: where the value stands, from 1 on; where: its place in words.
    """

    value: object
    source: str
    line: int
    where: str = 'the recipe'

    def error(self, reason: object) -> MarkedError:
        """Return the error that says why this value is refused."""
        return MarkedError(f'{self.source}:{self.line}: {reason}')

    def entries(self) -> dict[str, 'Marked']:
        """Return a dict's entries; raise MarkedError for another value."""
        if not isinstance(self.value, dict):
            raise self.error(f'{self.where} must be entries `name: value`, not {self.plain()!r}')
        return self.value

    def items(self) -> list['Marked']:
        """Return a list's items; raise MarkedError for another value."""
        if not isinstance(self.value, list):
            raise self.error(f'{self.where} must be a list, not {self.plain()!r}')
        return self.value

    def plain(self) -> object:
        """Return the value without lines."""
        if isinstance(self.value, dict):
            return {name: one.plain() for name, one in self.value.items()}
        return [one.plain() for one in self.value] if isinstance(self.value, list) else self.value

    def checked(self, check, *arguments) -> object:
        """Return check(place in words, the plain value, ...); its ValueError gets the line."""
        try:
            return check(self.where, self.plain(), *arguments)
        except ValueError as error:
            raise self.refused(error) from None

    def refused(self, error: ValueError) -> MarkedError:
        """Return an error of this value with its line, and what helps if YAML took it for text."""
        return self.error(f'{error}{_hint(self.value)}')


def read_text(path) -> str:
    """Return the text of a file; raise MarkedError where it cannot be read."""
    try:
        with opened(path, LARGEST) as file:
            return file.read().decode()
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise MarkedError(f'{path}: cannot be read: {reason}') from None


def parse(text: str, source: str) -> Marked:
    """
    Return what a YAML text says; source: its name in messages.

    Raises MarkedError for what is no YAML, is empty, has a key twice, an alias (a few of them make
    much of little), a tag of another class, or too many levels.
    """
    import yaml
    try:
        _check_events(yaml, text)
        node = yaml.compose(text, yaml.SafeLoader)
        if node is None:
            raise MarkedError(f'{source}:1: there is nothing in it')
        return _marked(yaml.SafeLoader(''), node, source, 'the recipe')
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else 1
        raise MarkedError(f'{source}:{line}: {error.problem or error.context}') from None
    except (yaml.YAMLError, ValueError) as error:
        if isinstance(error, MarkedError):
            raise
        raise MarkedError(f'{source}: {" ".join(str(error).split())[:200]}') from None


def _hint(value):
    """Return what helps where YAML has taken a number for a text, or ''."""
    if not isinstance(value, str):
        return ''
    try:
        float(value)
    except ValueError:
        return ''
    return ' (YAML reads a number with an exponent only with a point and a sign: 1.0e-3)'


def _check_events(yaml, text):
    """Refuse what would make much of little, and tags, before anything is made of it."""
    depth = 0
    for event in yaml.parse(text, yaml.SafeLoader):
        if isinstance(event, yaml.AliasEvent):
            raise yaml.MarkedYAMLError(problem='an alias is not taken here',
                                       problem_mark=event.start_mark)
        if isinstance(event, yaml.CollectionStartEvent):
            if event.tag not in TAGS:
                raise yaml.MarkedYAMLError(problem=f'the tag {event.tag} is not taken here',
                                           problem_mark=event.start_mark)
            depth += 1
            if depth > DEEPEST:
                raise yaml.MarkedYAMLError(problem=f'more than {DEEPEST} levels',
                                           problem_mark=event.start_mark)
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1


def _marked(loader, node, source, where):
    """Return a node of YAML as Marked."""
    line = node.start_mark.line + 1
    if node.id == 'scalar':
        return Marked(loader.construct_object(node), source, line, where)
    inner = '' if where == 'the recipe' else where
    if node.id == 'sequence':
        return Marked([_marked(loader, one, source, f'{inner}[{number}]')
                       for number, one in enumerate(node.value)], source, line, where)
    found = {}
    for key, value in node.value:
        name = loader.construct_object(key) if key.id == 'scalar' else None
        at = key.start_mark.line + 1
        if not isinstance(name, str):
            raise MarkedError(f'{source}:{at}: a name must be a text, not {key.value!r}')
        if name in found:
            raise MarkedError(f'{source}:{at}: {name} stands there twice')
        found[name] = _marked(loader, value, source, f'{inner}.{name}' if inner else name)
        found[name] = dataclasses.replace(found[name], line=at)
    return Marked(found, source, line, where)
