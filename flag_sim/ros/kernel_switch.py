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

"""Kernels that a node needs for new values: made ready beside it, while its frames go on."""
from collections.abc import Callable, Mapping
import time

from flag_sim.declarations.kernel_choice import KernelChoice
from flag_sim.jit.beside import CompilingProcess
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.holding import Holding
from flag_sim.ros.compiling import compiling
from rclpy.node import Node

POLL_PERIOD = 0.05
"""How often to look whether the kernels are compiled [s]."""


class KernelSwitch:
    """
    Decides which kernels a frame is served with, where its values ask for others than before.

    Kernels that are kept on the disk are loaded at once. Others are compiled in a process of
    their own: meanwhile frames in real time are served with the old ones, and those of lockstep
    are held, so that the same shot is the same to the byte.

    node: whose frames these are. choice: how values choose kernels. values: those whose kernels
    the node has. serve(): serves what was held.
    """

    def __init__(self, node: Node, choice: KernelChoice, values: Mapping,
                 serve: Callable[[], None]):
        self._node, self._choice, self._serve = node, choice, serve
        self._present, self._loaded = dict(values), {choice.name(values)}
        self._holding = Holding()
        self._process = self._timer = None
        self._wanted, self._begin, self._is_told = {}, 0.0, False

    @property
    def is_compiling(self) -> bool:
        """Return whether kernels are compiled beside."""
        return self._process is not None

    def may_serve(self, frame: FrameId, values: Mapping) -> bool:
        """Return whether a frame with these values can be served, with these kernels or others."""
        if self._has(values):
            self._holding.end()  # who lacks something later is held anew
            return True
        return self._holding.may_pass(frame)

    def usable(self, values: Mapping) -> Mapping:
        """Return a frame's values, but those that choose kernels as before if these lack."""
        if self._has(values):
            self._present = dict(values)
            return values
        if not self._is_told:
            self._is_told = True
            self._node.get_logger().info(
                f'{self._choice.name(values)} is not compiled yet: frames in real time go on with '
                f'{self._choice.name(self._present)}')
        return {**values, **self._choice.chosen(self._present)}

    def restart(self) -> None:
        """Note that another take or round begins, which may be in lockstep."""
        self._holding.end()

    def close(self) -> None:
        """End what is compiled beside, if anything is."""
        if self._process is not None:
            self._process.end()
            self._node.destroy_timer(self._timer)
            self._process = self._timer = None

    def _has(self, values):
        """Return whether the kernels are loaded, or can be at once; else have them compiled."""
        what = self._choice.name(values)
        if what in self._loaded:
            return True
        if self._process is not None and self._choice.name(self._wanted) == what:
            return False
        if self._choice.load(values):
            self._loaded.add(what)
            return True
        self.close()
        self._wanted, self._begin, self._is_told = dict(values), time.monotonic(), False
        self._process = CompilingProcess(self._choice.program(values))
        self._timer = self._node.create_timer(POLL_PERIOD, self._look)
        self._node.get_logger().info(
            f'compiling {what} in a process beside: frames of lockstep wait for it')
        return False

    def _look(self):
        """Take the kernels over once they are compiled, and serve what waits for them."""
        if self._process is None or not self._process.is_over:
            return
        self.close()
        what = self._choice.name(self._wanted)
        if not self._choice.load(self._wanted):  # nothing is kept here, or it was killed
            with compiling(self._node, what):
                self._choice.warm_up(self._wanted)
        self._loaded.add(what)
        self._holding.end()
        self._node.get_logger().info(
            f'{what} takes over, compiled in {time.monotonic() - self._begin:.1f} s')
        self._serve()
