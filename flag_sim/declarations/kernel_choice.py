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

"""Which kernels values ask for, and how they are made ready before the first frame with them."""
from collections.abc import Callable, Mapping
from typing import NamedTuple

from flag_sim.jit.cache import loading_alone, NotKept


class KernelChoice(NamedTuple):
    """
    Kernels that parameters choose.

    parameters: their names. name(values): in words what the kernels are compiled for.
    warm_up(values): compiles or loads them; of a module, so that another process can call it.
    """

    parameters: tuple[str, ...]
    name: Callable[[Mapping], str]
    warm_up: Callable[[Mapping], None]

    def load(self, values: Mapping) -> bool:
        """Load the kernels if all are kept; return whether they were, else compile none."""
        try:
            with loading_alone():
                self.warm_up(values)
        except NotKept:
            return False
        return True

    def chosen(self, values: Mapping) -> dict:
        """Return the values that choose."""
        return {name: values[name] for name in self.parameters}

    def program(self, values: Mapping) -> str:
        """Return a program in Python that compiles or loads the kernels, and so keeps them."""
        name = self.warm_up.__name__
        return f'from {self.warm_up.__module__} import {name}; {name}({self.chosen(values)!r})'
