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

"""
Parameters declared beside the fields that they set.

A frozen dataclass with fields made by `declared` states each field's valid range once. The class
validates itself with it (`Declared`) and a node exposes the same fields as parameters (`Group`):

>>> @dataclass(frozen=True)
... class Air(Declared):
...     density: float = declared(1.2, 'density of the air', 'kg/m3', 0.0, 1000.0)
>>> [parameter.name for parameter in Group(Air(), 'air.')]
['air.density']
>>> Group(Air(), 'air.').make({'air.density': 0.5})
Air(density=0.5)
"""
from collections.abc import Iterator, Mapping
import dataclasses
import functools

from flag_sim.parameters.declaration import Declaration

KEY = 'declaration'  # in the metadata of a dataclass's field


def declared(default: object, effect: str, unit: str = '', low: float = None, high: float = None,
             **more) -> dataclasses.Field:
    """
    Return a dataclass's field with its Declaration.

    more: other fields of Declaration. name: the parameter's name if it is not prefix + field name.
    A tuple is a list of its length. `{...}` in `effect` is filled from the Group's `words`.
    """
    if isinstance(default, tuple):
        more = {'length': len(default), **more}
    value = list(default) if isinstance(default, tuple) else default
    declaration = Declaration(more.pop('name', ''), value, effect, unit, low, high, **more)
    return dataclasses.field(default=default, metadata={KEY: declaration})


@functools.cache
def _declarations(record: type) -> dict[str, Declaration]:
    """Return {field: declaration, named as the field} of the declared fields of a dataclass."""
    return {field.name: dataclasses.replace(field.metadata[KEY], name=field.name)
            for field in dataclasses.fields(record) if KEY in field.metadata}


class Declared:
    """
    Base of frozen dataclasses that check their declared fields.

    A field is kept in its own type. Raises ValueError with the field's name, the rule and the
    value for a value that its declaration refuses.
    """

    def __post_init__(self):
        """Refuse what a declaration refuses."""
        for name, declaration in _declarations(type(self)).items():
            object.__setattr__(self, name, declaration.convert(getattr(self, name)))

    @classmethod
    def accepted(cls, field: str, value: object, name: str = '') -> object:
        """Return a value as a field would hold it; raises ValueError, by another name if given."""
        return _declarations(cls)[field].convert(value, name)


class Group:
    """
    The declared fields of a record as parameters of a node, in their order.

    record: a Declared whose values are the defaults. prefix: of the parameters' names.
    exclude: fields that are no parameters. words: fill `{...}` in the effects.
    """

    def __init__(self, record: Declared, prefix: str = '', exclude: tuple = (), **words: str):
        self._record = record
        self._fields = {}
        for field in dataclasses.fields(record):
            if KEY in field.metadata and field.name not in exclude:
                declaration, default = field.metadata[KEY], getattr(record, field.name)
                self._fields[field.name] = dataclasses.replace(
                    declaration, name=declaration.name or prefix + field.name,
                    default=list(default) if declaration.is_list else default,
                    effect=declaration.effect.format(**words))

    def __iter__(self) -> Iterator[Declaration]:
        """Iterate over the declarations, with the parameters' full names."""
        return iter(self._fields.values())

    def pick(self, *fields: str) -> tuple[Declaration, ...]:
        """Return the declarations of some fields."""
        return tuple(self._fields[field] for field in fields)

    def without(self, *fields: str) -> tuple[Declaration, ...]:
        """Return the declarations of all fields but some."""
        return tuple(declaration for field, declaration in self._fields.items()
                     if field not in fields)

    def arguments(self, values: Mapping[str, object]) -> dict[str, object]:
        """Return {field: value} from {parameter: value}, in which there may be others too."""
        return {field: values[declaration.name] for field, declaration in self._fields.items()}

    def make(self, values: Mapping[str, object]) -> Declared:
        """Build the record from {parameter: value}; errors name the parameter."""
        try:
            return dataclasses.replace(self._record, **self.arguments(values))
        except ValueError:
            for declaration in self:
                declaration.convert(values[declaration.name])
            raise
