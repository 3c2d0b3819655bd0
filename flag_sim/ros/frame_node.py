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

"""Base of physics and renderer: a frame arrives, the node works on it and publishes."""
from collections.abc import Hashable, Iterable, Mapping
import os

from flag_sim.declarations.nodes import own_values
from flag_sim.parameters.declaration import Declaration
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.serving import FrameServer, Handlers
from flag_sim.ros import frame_message
from flag_sim.ros.diagnostics import compute_time, Diagnostics, ERROR, OK
from flag_sim.ros.parameter_node import ParameterNode
from flag_sim.ros.topics import subscribe
import numpy as np


class FrameNode(ParameterNode):
    """
    Serves frames in order; a frame that comes again gets the answer that was kept.

    Derived nodes define `work`, which makes a frame's answer, and `answer`, which publishes it;
    `status` says how they are doing.
    """

    def __init__(self, name: str, declarations: Iterable[Declaration]):
        super().__init__(name, declarations)
        self._role = name  # whatever the node itself is called
        # What comes with a frame: its wind and keyed values.
        self._server = FrameServer(Handlers(
            self.is_ready, self._work, lambda stamp, answer: self.answer(stamp, answer),
            self._restart))
        self._good = None   # values that the take's last frame was served with
        self._clash = ''    # why keyed values of the last frame could not be used
        # The network cannot deliver before it is spun, and it is spun only once all is ready.
        self._frames = frame_message.FrameReader()
        subscribe(self, 'parameters', self._on_parameters, raw=True)
        self._diagnostics = Diagnostics(self, self._status)
        processors = len(os.sched_getaffinity(0))
        if self.values['threads'] > processors:
            self.get_logger().warning(
                f'threads = {self.values["threads"]} is more than this process has processors, '
                f'{processors}: frames take longer than with {processors}')

    def check_wind(self, wind: np.ndarray) -> None:
        """Raise ValueError for a wind (3,) [m/s] that the node cannot work with."""

    def restart(self, frame: FrameId) -> None:
        """Forget the take or round that was played; another one begins with `frame`."""

    def is_ready(self, frame: FrameId) -> bool:
        """Return whether everything that the frame needs has arrived."""
        del frame
        return True

    def work(self, frame: FrameId, wind: np.ndarray, values: Mapping) -> object:
        """Return the frame's answer, given the wind (3,) [m/s] and its values {name: value}."""
        raise NotImplementedError

    def answer(self, stamp: int, answer: object) -> None:
        """Publish the answer to the frame at `stamp` [ns], for the first time or again."""
        raise NotImplementedError

    def status(self) -> tuple[bytes, str, dict]:
        """Return (level, message, {name with unit: value}) of the node, for its `state`."""
        return OK, 'serving frames' if self._stopwatch.frames else 'waiting for frames', {}

    def _status(self):
        level, message, values = self.status()
        if self._clash:
            level, message = ERROR, self._clash
        return level, message, {'frames served': self._stopwatch.frames,
                                **compute_time(self._stopwatch), **values}

    def _on_parameters(self, data, info):
        try:
            frame, wind, keyed = self._frames.read(data)
            self.check_wind(wind)
            values = self._own_values(keyed)
        except ValueError as error:
            self.refuse('parameters', error)
            return
        self.take_frame(frame, wind, values, bytes(info['publisher_gid']['data']))

    def _own_values(self, keyed):
        """Return the keyed values that are this node's own, checked against its declarations."""
        return {name: self.accept_change(name, value)
                for name, value in own_values(self._role, keyed).items()}

    def _merge(self, keyed):
        """
        Return the values that a frame is served with: the node's own and, before them, the keyed.

        Keyed values that are right one by one but cannot stand together, which the wind cannot
        know, are reported, and the frame gets the values of the one before: refused, it would be
        sent again forever in lockstep.
        """
        values = {**self.values, **keyed}
        self._clash = ''
        if keyed:
            try:
                self.check(values)
            except ValueError as error:
                self._clash = ('keyed values are refused, the frame keeps those of the one '
                               f'before: {error}')
                self._log.error(self._clash, 'keyed values')
                values = self._good or dict(self.values)
        self._good = values
        return values

    def take_frame(self, frame: FrameId, wind: np.ndarray | None, keyed: Mapping,
                   sender: Hashable) -> None:
        """
        Queue a frame until its turn, and serve the frames whose turn has come.

        wind: (3,) [m/s]; keyed: {name: value} of the node's own parameters at this frame; sender:
        identifies the publisher.
        """
        self._server.take_frame(frame, (wind, keyed), sender)

    def _restart(self, frame):
        self._good = None
        self.restart(frame)

    def _work(self, frame, came_with):
        wind, keyed = came_with
        # A value set by a user takes effect from this frame on, unless it is keyed.
        with self._stopwatch.measure('work'):
            answer = self.work(frame, wind, self._merge(keyed))
        self._stopwatch.frames += 1
        return answer

    def refuse(self, topic: str, error: ValueError) -> None:
        """Warn of a message that cannot be used."""
        self._log.warn(f'a message on {topic} is refused: {error}', topic)

    def close(self) -> None:
        """Log where the time went."""
        self.get_logger().info(self._stopwatch.summary())
