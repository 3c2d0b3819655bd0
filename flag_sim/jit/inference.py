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
What makes compiling quicker without a change of what is compiled.

Most of it is spent in Python: numba looks up what every operation returns each time that it comes
upon it, some thousand times a kernel with some hundred different answers, and makes many objects
that live, among which Python looks for others to collect.
"""
from collections.abc import Iterator
import contextlib
import gc

from numba.core import types
from numba.core.targetconfig import ConfigStack

COLLECT_AFTER = 100_000
"""New objects after which Python looks for others to collect while kernels are compiled."""

_known = {}  # {options of a compilation: {(function, types): signature}}


@contextlib.contextmanager
def few_collections() -> Iterator[None]:
    """Let Python collect garbage rarely in the `with` block."""
    before = gc.get_threshold()
    gc.set_threshold(max(before[0], COLLECT_AFTER) if before[0] else 0, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


@contextlib.contextmanager
def remembered_calls(context) -> Iterator[None]:
    """
    Let a typing context of numba's remember, in the `with` block, what calls return.

    Other kernels are left out, which remember that by themselves. What numba's own functions in
    Python return depends on the options that they are compiled with, so these are told apart.
    The method that is replaced is private to numba.
    """
    if 'resolve_function_type' in vars(context):  # a kernel that another one calls
        yield
        return
    resolve = context.resolve_function_type
    options = signatures = None

    def resolve_once(function, arguments, keywords):
        nonlocal options, signatures
        if keywords or isinstance(function, types.Dispatcher):
            return resolve(function, arguments, keywords)
        present = ConfigStack.top_or_none()
        if present is not options or signatures is None:
            options, signatures = present, _known.setdefault(present, {})
        known, key = signatures, (function, arguments)  # resolve may compile with other options
        try:
            signature = known.get(key)
        except TypeError:  # a slice among the arguments has no hash
            return resolve(function, arguments, keywords)
        if signature is None:
            signature = resolve(function, arguments, keywords)
            if signature is not None:
                known[key] = signature
        return signature

    context.resolve_function_type = resolve_once
    try:
        yield
    finally:
        del context.resolve_function_type
