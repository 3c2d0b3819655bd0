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

"""The sections of the report, one module each: to add one is to add a file here."""
from collections.abc import Iterator
import importlib
import pkgutil
from typing import Protocol

from flag_sim.study.runner import Batch
from flag_sim.study.store import Store


class Section(Protocol):
    """
    What a section's module has; a module without a PLACE is shared by sections.

    Columns of rows end with their unit (`rms_mm`). Every number in them but times (`_ms`) is the
    same in every run. A module that has nothing to measure yields no batches; one that has nothing
    to draw has no plots.
    """

    PLACE: float  # in the report; lower ones are measured first
    NAME: str     # of its rows' file, NAME.csv
    SHARE: float  # of the study's time, in parts of the sum of all shares

    def batches(store: Store) -> Iterator[Batch]:
        """Yield its rows, the most important first: a short study has only the first of them."""

    def text(store: Store) -> str:
        """Return its Markdown text, heading (##) and tables; '' where nothing was measured."""

    def plots(store: Store) -> Iterator[tuple[str, str]]:
        """Draw into store.folder; yield (file name, what to see there). Needs matplotlib."""


def all_sections() -> list[Section]:
    """Return the modules that are sections, by their place."""
    modules = [importlib.import_module(f'{__name__}.{found.name}')
               for found in pkgutil.iter_modules(__path__)]
    return sorted((module for module in modules if hasattr(module, 'PLACE')),
                  key=lambda module: module.PLACE)
