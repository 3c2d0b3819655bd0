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
"""Properties of classes: one that is checked where it is set, and one that can only be read."""
from collections.abc import Callable


def setting(name: str, check: Callable, doc: str) -> property:
    """Return a property that check(name, value) has to pass, and that does nothing else."""
    private = f'_{name}'
    return property(lambda self: getattr(self, private),
                    lambda self, value: setattr(self, private, check(name, value)), doc=doc)


def view(name: str, doc: str) -> property:
    """Return a property that can only be read: of the attribute with an underscore before it."""
    return property(lambda self: getattr(self, f'_{name}'), doc=doc)
