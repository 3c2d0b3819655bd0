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

"""What users are told while kernels are compiled or loaded."""
import contextlib
import threading
import time

from flag_sim.kernels import compilations


@contextlib.contextmanager
def compiling(node, what, seconds=1.0):
    """
    Tell the user what is compiled in the `with` block, if it takes long, and when it is ready.

    Kernels take many seconds the first time, and later, when they are only loaded, none unless
    the machine is busy: the user is told which. The node does nothing else meanwhile.
    """
    begin, before = time.monotonic(), compilations()

    def tell():
        node.get_logger().info(f'compiling {what}: frames wait for it, half a minute at most '
                               'unless the machine is busy; later starts load what is kept now'
                               if compilations() > before else
                               f'loading {what}, which an earlier start has compiled: frames wait '
                               'for it')
    timer = threading.Timer(seconds, tell)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
    spent = time.monotonic() - begin
    if spent > seconds:
        done = 'compiled' if compilations() > before else 'loaded'
        node.get_logger().info(f'{done} {what} in {spent:.1f} s')
