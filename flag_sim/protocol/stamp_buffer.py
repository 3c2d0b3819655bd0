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

"""A buffer, by stamp, for what has arrived for frames whose turn has not come."""
from collections.abc import Collection, Iterator
from typing import Generic, TypeVar

Value = TypeVar('Value')


class StampBuffer(Generic[Value]):
    """
    Keeps one value a stamp [ns], those of the latest `size` arrivals.

    By arrival, not by stamp: the first stamps of a round are its newest.
    """

    def __init__(self, size: int):
        self._size = size
        self._values: dict[int, Value] = {}  # in the order of arrival

    def __len__(self) -> int:
        return len(self._values)

    def __contains__(self, stamp: int) -> bool:
        return stamp in self._values

    def __iter__(self) -> Iterator[int]:
        """Yield the stamps in their order."""
        return iter(sorted(self._values))

    def __getitem__(self, stamp: int) -> Value:
        """Return the value of a stamp, which stays."""
        return self._values[stamp]

    def put(self, stamp: int, value: Value) -> None:
        """Keep a value; an older one of the same stamp is replaced."""
        self._values.pop(stamp, None)
        self._values[stamp] = value
        while len(self._values) > self._size:
            del self._values[next(iter(self._values))]

    def take(self, stamp: int) -> Value:
        """Return the value of a stamp, and keep only those of later ones."""
        value = self._values[stamp]
        self._values = {later: kept for later, kept in self._values.items() if later > stamp}
        return value

    def pop(self, stamp: int) -> Value:
        """Return the value of a stamp, which is not kept any longer."""
        return self._values.pop(stamp)

    def keep(self, stamps: Collection[int]) -> None:
        """Keep only the values of these stamps."""
        self._values = {stamp: kept for stamp, kept in self._values.items() if stamp in stamps}
