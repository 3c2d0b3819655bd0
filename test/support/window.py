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

"""The viewer's window with real nodes, all in this process and in one thread."""
import contextlib
import functools
import time

from flag_sim.nodes.physics import Physics
from flag_sim.nodes.renderer import Renderer
from flag_sim.nodes.viewer import Viewer
from flag_sim.nodes.wind import Wind
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from support.watch import PATIENCE

SMALL = ('grid.rows:=5', 'grid.columns:=6', 'width:=64', 'height:=48', 'threads:=1')
KINDS = {'wind': Wind, 'physics': Physics, 'renderer': Renderer}


@functools.cache  # PyQt's ends when nobody refers to it
def application():
    """Return the one QApplication of this process."""
    from flag_sim.viewer.application import why_unsound
    from qtpy.QtWidgets import QApplication
    made = QApplication.instance() or QApplication(['test'])
    assert not why_unsound(), why_unsound()  # else it is Python that ends, somewhere later
    return made


class Desk:
    """
    A window, a viewer node and the nodes `names`, in a domain.

    given: parameters of all nodes at their start; remaps: rules. Nothing happens but within
    `until`.
    """

    def __init__(self, domain, *given, names=('physics', 'renderer', 'wind'), namespace='/',
                 remaps=()):
        self._application = application()
        self._given = [*SMALL, *given]
        self._domain = domain
        self._names = names
        self._namespace = namespace
        self._remaps = [part for one in remaps for part in ('-r', one)]
        self.nodes = {}

    def start(self, name):
        """Start a node of the package."""
        self.nodes[name] = KINDS[name]()
        self._executor.add_node(self.nodes[name])

    def end(self, name):
        """End a node as its process would."""
        node = self.nodes.pop(name)
        self._executor.remove_node(node)
        node.close()
        node.destroy_node()

    def until(self, condition, seconds=PATIENCE):
        """Let everything happen until `condition()` holds; fail if it does not in time."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, 'waited in vain'
            self._executor.spin_once(timeout_sec=0.01)
            self._application.processEvents()

    def put(self, name, **values):
        """Set parameters of a node as another client would; `__` stands for a dot."""
        results = self.nodes[name].set_parameters([
            Parameter(key.replace('__', '.'), value=value) for key, value in values.items()])
        assert all(result.successful for result in results), results

    def put_all(self, name, values):
        """Set parameters {name: value} of a node together, as another client would."""
        result = self.nodes[name].set_parameters_atomically([
            Parameter(key, value=value) for key, value in values.items()])
        assert result.successful, result

    def value(self, name, parameter):
        """Return what a node itself has as a parameter's value."""
        return self.nodes[name].values.get(parameter)

    @property
    def model(self):
        """Return what the window knows."""
        return self.window.model

    def __enter__(self):
        """Return self, with all nodes known to the window."""
        from flag_sim.viewer.application import Bridge
        from flag_sim.viewer.window import Window
        self._cleanup = contextlib.ExitStack()
        given = [part for one in self._given for part in ('-p', one)]
        self._cleanup.enter_context(rclpy.init(
            domain_id=self._domain,
            args=['--ros-args', '-r', f'__ns:={self._namespace}', *self._remaps, *given]))
        self._executor = SingleThreadedExecutor()
        self.viewer = Viewer()
        self._executor.add_node(self.viewer)
        for name in self._names:
            self.start(name)
        exchange = self.viewer.exchange
        # As the EventsExecutor's `defer` does; this executor is spun for a moment at a time.
        exchange.wake_ros = lambda: self._executor.create_task(self.viewer._serve)
        self.window = Window(exchange.ask, lambda: exchange.left_out)
        self._bridge = Bridge(self.window, exchange)
        self.window.show()
        self.until(lambda: all(map(self.model.is_known, self._names)))
        return self

    def __exit__(self, *_):
        """End everything."""
        self.window.close()
        self.viewer.exchange.wake_window = None
        for name in [*self.nodes]:
            self.end(name)
        self._executor.remove_node(self.viewer)
        self.viewer.close()
        self.viewer.destroy_node()
        self._executor.shutdown()
        self._cleanup.close()
        self.window.deleteLater()
        self._application.processEvents()
