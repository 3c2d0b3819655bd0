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

"""The parameters of every node, in the order in which people meet them."""
from collections.abc import Iterator, Mapping
from importlib import import_module

from flag_sim.parameters.declaration import Declaration


class Nodes(Mapping):
    """
    {node: its declarations}, each imported when it is asked for.

    What physics and renderer declare stands beside their kernels: to import it takes 0.3 s and
    70 MB. The wind, which animates it, does so at its start (see keyable); recorder, player
    and viewer do without.
    """

    def __init__(self, *names: str):
        self._names = names

    def __iter__(self) -> Iterator[str]:
        """Iterate over the nodes' names."""
        return iter(self._names)

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self._names)

    def __getitem__(self, node: str) -> tuple[Declaration, ...]:
        """Return the declarations of a node."""
        if node not in self._names:
            raise KeyError(node)
        return getattr(import_module(f'flag_sim.declarations.{node}'), node.upper())


SHARED = 'scene'
"""What stands for physics and renderer together in the name of a track."""
NODES = Nodes('wind', 'physics', 'renderer', 'recorder', 'player', 'viewer')


def scene() -> tuple[Declaration, ...]:
    """Return the declarations that physics and renderer share."""
    return import_module('flag_sim.declarations.scene').SCENE


def own_values(role: str, keyed: Mapping[str, object]) -> dict[str, object]:
    """Return {parameter: value} of a node's own among {track: value}; those of its role win."""
    found = {}
    for prefix in (f'{SHARED}.', f'{role}.'):
        found |= {track.removeprefix(prefix): value for track, value in keyed.items()
                  if track.startswith(prefix)}
    return found


def named(node: str) -> dict[str, Declaration]:
    """Return {parameter name: declaration} of a node."""
    return {declaration.name: declaration for declaration in NODES[node]}


def defaults(node: str) -> dict[str, object]:
    """Return {parameter name: default} of a node."""
    return {declaration.name: declaration.default for declaration in NODES[node]}
