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

"""Log lines while kernels are compiled or loaded."""
from collections.abc import Iterator
import contextlib
import threading
import time

from flag_sim.jit.cache import compilations
from rclpy.node import Node


@contextlib.contextmanager
def compiling(node: Node, what: str, seconds: float = 1.0) -> Iterator[None]:
    """
    Log what is compiled in the `with` block, if it takes `seconds` [s], and when it is ready.

    Kernels take many seconds the first time, and later, when they are only loaded, none unless
    the machine is busy: the log says which. The node does nothing else meanwhile.
    """
    begin, before = time.monotonic(), compilations()
    over = threading.Event()

    def is_compiled():
        return compilations() > before

    def report():
        reported = None
        while not over.wait(seconds):
            if is_compiled() != reported:
                reported = is_compiled()
                node.get_logger().info(
                    f'compiling {what}: frames wait for it, half a minute at most unless the '
                    'machine is busy; later starts load the result' if reported else
                    f'loading {what}: frames wait for it')
    reporter = threading.Thread(target=report, daemon=True)
    reporter.start()
    try:
        yield
    finally:
        over.set()
        reporter.join()
    spent = time.monotonic() - begin
    if spent > seconds:
        node.get_logger().info(
            f'{"compiled" if is_compiled() else "loaded"} {what} in {spent:.1f} s')
