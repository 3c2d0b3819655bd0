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
Which attributes an object has: those that its class gives it, and no others.

Python allows setting an attribute of any name. One that is never read, because it is mistyped or
belongs to another object, would be accepted without effect. Both functions here are decorators of
classes. Objects of a subclass stay open: what they have is for its author to say.
"""
import dataclasses
import functools


def closed(cls: type) -> type:
    """Refuse new attributes on a class's objects, once they are made."""
    def refusal(thing, name):
        if hasattr(type(thing), name) or name in thing.__dict__:
            return None
        known = _settable(type(thing))
        for part in known:
            if name in _fields(getattr(thing, part)):
                return (f"{_kind(thing)} has no attribute '{name}': it is a field of {part}; "
                        f'set {part} = dataclasses.replace({part}, {name}=...)')
        return (f"{_kind(thing)} has no attribute '{name}'; those that can be set are "
                + ', '.join(known))
    return _guarded(cls, refusal)


def constant(cls: type) -> type:
    """Make the public attributes of a class's objects read-only, once they are made."""
    def refusal(thing, name):
        if name.startswith('_'):
            return None
        if hasattr(thing, name):
            return f'{name} of a {_kind(thing)} cannot be changed; make another {_kind(thing)}'
        return f"{_kind(thing)} has no attribute '{name}'"
    return _guarded(cls, refusal)


def _guarded(cls, refusal):
    """Return the class with `refusal(object, name)`, a reason or None, asked before setting."""
    init = cls.__init__

    @functools.wraps(init)
    def __init__(self, *args, **kwargs):
        init(self, *args, **kwargs)
        self.__dict__['_is_made'] = type(self) is cls

    def __setattr__(self, name, value):
        reason = refusal(self, name) if self.__dict__.get('_is_made') else None
        if reason:
            raise AttributeError(reason)
        object.__setattr__(self, name, value)

    cls.__init__, cls.__setattr__ = __init__, __setattr__
    return cls


def _kind(thing):
    return type(thing).__name__


def _settable(cls):
    """Return the names of a class's properties that can be set."""
    return sorted(name for name in dir(cls) if isinstance(getattr(cls, name), property)
                  and getattr(cls, name).fset)


def _fields(value):
    """Return the names of a dataclass's fields; none of anything else."""
    return [f.name for f in dataclasses.fields(value)] if dataclasses.is_dataclass(value) else []
