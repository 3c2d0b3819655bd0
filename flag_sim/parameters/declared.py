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

A frozen dataclass whose fields are made by `declared` says once what each may be. The class checks
itself by that (Declared), and a node has the same fields as parameters (Group):

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

    more: `name`, of the parameter where it is not the group's prefix and the field's name, and
    other fields of Declaration. A tuple is a list of its length. Braces in `effect` are filled by
    a group's words.
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

    record: a Declared whose values are the defaults. prefix: of the parameters' names. but:
    fields that are no parameters. words: what stands in the effects for {…}.
    """

    def __init__(self, record: Declared, prefix: str = '', but: tuple = (), **words: str):
        self._record = record
        self._fields = {}
        for field in dataclasses.fields(record):
            if KEY in field.metadata and field.name not in but:
                declaration, default = field.metadata[KEY], getattr(record, field.name)
                self._fields[field.name] = dataclasses.replace(
                    declaration, name=declaration.name or prefix + field.name,
                    default=list(default) if declaration.is_list else default,
                    effect=declaration.effect.format(**words))

    def __iter__(self) -> Iterator[Declaration]:
        """Iterate over the declarations, with the parameters' full names."""
        return iter(self._fields.values())

    def only(self, *fields: str) -> tuple[Declaration, ...]:
        """Return the declarations of some fields."""
        return tuple(self._fields[field] for field in fields)

    def but(self, *fields: str) -> tuple[Declaration, ...]:
        """Return the declarations of all other fields."""
        return tuple(one for field, one in self._fields.items() if field not in fields)

    def arguments(self, values: Mapping[str, object]) -> dict[str, object]:
        """Return {field: value} of {parameter: value}, in which there may be others' too."""
        return {field: values[one.name] for field, one in self._fields.items()}

    def make(self, values: Mapping[str, object]) -> Declared:
        """Return the record of {parameter: value}; raises ValueError by the parameters' names."""
        try:
            return dataclasses.replace(self._record, **self.arguments(values))
        except ValueError:
            for one in self:
                one.convert(values[one.name])
            raise
