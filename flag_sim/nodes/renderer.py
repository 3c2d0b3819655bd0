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

"""The renderer node: draws the cloth of every `vertices` message into an image."""
import sys
import time

from flag_sim.declarations.making import look_of
from flag_sim.declarations.nodes import RENDERER, SCENE
from flag_sim.drawing import Picture
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from flag_sim.ros.compiling import compiling
from flag_sim.ros.frame_node import FrameNode
from flag_sim.ros.lifecycle import run
from flag_sim.ros.throttled_log import Waiting
from flag_sim.ros.topics import DEPTH, publish, publishers, subscribe
import numpy as np

# Vertices may come before the wind is discovered; only after this time does its absence mean
# that they are played back alone, without parameters [s].
GRACE = 1.0
LOOK_AGAIN = 5.0  # how often a second sender of vertices is looked for [s]


class Shot:
    """A frame's picture: what it is drawn from, and the messages that were asked for so far."""

    def __init__(self, cloud, look):
        self.cloud = cloud
        self.look = look
        self.is_drawn = False
        self.messages = {}


class Renderer(FrameNode):
    """Publishes image, camera_info and depth of the frames whose vertices and parameters came."""

    def __init__(self):
        super().__init__('renderer', SCENE + RENDERER)
        self._values = self._look = None
        self._clouds = {}  # (positions, normals) by stamp, in the order of arrival
        self._first = None  # stamp of the take's first frame [ns]
        self._warm_up()
        # Made after that, for the number of threads is chosen by how long its first frames take.
        self._picture = Picture(self.values['threads'])
        self._camera_out = {name: publish(self, f'camera/{name}')
                            for name in ('image_raw', 'camera_info', 'depth/image_raw')}
        self._frame_done_out = publish(self, 'frame_done')
        self._start = time.monotonic()
        subscribe(self, 'vertices', self._on_vertices)
        self._grace = self.create_timer(GRACE, self._end_grace)
        self._several = self.create_timer(LOOK_AGAIN, self._look_for_several)
        self._waiting = Waiting(self, self._missing, lambda: self._stopwatch.frames)
        self.get_logger().info(
            f'{self.values["width"]} x {self.values["height"]} pixels, waiting for vertices')

    def _warm_up(self):
        """Compile or load the kernels of the present kind of picture before the first frame."""
        square = np.array([[[0.0, 0.0, 9.0], [1.0, 0.0, 9.0]], [[0.0, 0.0, 8.0], [1.0, 0.0, 8.0]]])
        with compiling(self, 'the rasterizer'):
            Picture().draw(square, None, *look_of(self.values))

    def check(self, values):
        """Refuse values of which no picture can be made."""
        look_of(values)

    def restart(self, frame):
        """
        Forget the clouds of the take before; those of the frames that wait came early.

        Without a wind there are no takes, and none is forgotten.
        """
        self._first = frame.stamp
        if frame.take is not None:
            early = {waiting.stamp for waiting in self._order.waiting.values()}
            self._clouds = {stamp: c for stamp, c in self._clouds.items() if stamp in early}

    def is_ready(self, frame):
        """Return whether the frame's vertices have come."""
        return frame.stamp in self._clouds

    def _on_vertices(self, message, info):
        stamp = messages.to_stamp(message.header.stamp)
        try:
            cloud = messages.read_cloud(message)
        except ValueError as error:
            self.refuse('vertices', error)
            return
        if self.answer_again(stamp):
            return
        if stamp == self._first:
            self._clouds.clear()  # they came late, from the take before
        self._clouds.pop(stamp, None)
        self._clouds[stamp] = cloud
        while len(self._clouds) > DEPTH:  # by arrival: the first stamps of a round are its newest
            del self._clouds[next(iter(self._clouds))]
        self.serve()
        if stamp in self._clouds:
            self._serve_alone(bytes(info['publisher_gid']['data']))

    def _serve_alone(self, sender):
        """Draw what came without parameters, if there is nobody who could still send them."""
        if time.monotonic() - self._start < GRACE or self.count_publishers('parameters'):
            return
        for stamp in sorted(self._clouds):
            self.take_frame(FrameId(stamp, None, stamp, stamp), None, {}, sender)

    def _missing(self):
        """Return in words what the next frame lacks: its vertices or, with them, parameters."""
        lacking = [frame.stamp for frame in self._order.waiting.values()
                   if not self.is_ready(frame)]
        if lacking:
            frame = f'vertices of the frame at {min(lacking) / 1e9:.3f} s'
            senders = publishers(self, 'vertices')
            return (f'{frame}: {senders} has not sent them, its log says why' if senders else
                    f'{frame}: nobody publishes them, is physics running?')
        # A single cloud may be a late copy; nobody plays that.
        senders = publishers(self, 'parameters')
        if len(self._clouds) > 1 and senders:  # without any, the next one is drawn alone
            return (f'parameters of the frame at {min(self._clouds) / 1e9:.3f} s, whose vertices '
                    f'have come: {senders} publishes parameters, but not '
                    'of this frame; end it, and vertices are drawn alone')
        return ''

    def _look_for_several(self):
        """Warn, once, of several publishers of vertices."""
        if self.count_publishers('vertices') > 1:
            self.get_logger().warning(
                f'{self.count_publishers("vertices")} publishers of vertices '
                f'({publishers(self, "vertices")}): frames are drawn from one or the other')
            self.destroy_timer(self._several)

    def _end_grace(self):
        self.destroy_timer(self._grace)
        self._serve_alone(None)

    def work(self, frame, wind, values):
        """Return the frame's Shot; it is drawn when somebody listens."""
        if values != self._values:
            self._values, self._look = values, look_of(values)
        cloud = self._clouds.pop(frame.stamp)
        self._clouds = {stamp: c for stamp, c in self._clouds.items() if stamp > frame.stamp}
        shot = Shot(cloud, self._look)
        self._draw(frame.stamp, shot)
        return shot

    def _listened(self):
        return [name for name, publisher in self._camera_out.items()
                if publisher.get_subscription_count()]

    def _draw(self, stamp, shot):
        """
        Make the messages that somebody listens to and that are not made yet.

        A frame is drawn once: who begins to listen to its depth when it is drawn without begins
        with the next one.
        """
        listened = self._listened()
        if 'camera_info' in listened and 'camera_info' not in shot.messages:
            shot.messages['camera_info'] = messages.camera_info_message(stamp, shot.look.camera)
        with_depth = 'depth/image_raw' in listened
        if not shot.is_drawn and (with_depth or 'image_raw' in listened):
            shot.is_drawn = True
            channels = ['depth'] if with_depth else []
            frame = self._picture.draw(*shot.cloud, *shot.look, channels)
            shot.messages['image_raw'] = messages.image_message(stamp, frame.colour)
            if with_depth:
                shot.messages['depth/image_raw'] = messages.depth_message(stamp, frame.depth)

    def status(self):
        """Return the level, a message and the size of the pictures."""
        level, message, values = super().status()
        present = self._values or self.values
        return level, message, {**values, 'width [pixels]': present['width'],
                                'height [pixels]': present['height']}

    def answer(self, stamp, shot):
        """Publish the picture, then say that the frame is done."""
        self._draw(stamp, shot)  # for those who have begun to listen since the frame was served
        with self._stopwatch.share('publish'):
            for name in self._listened():
                if name in shot.messages:
                    self._camera_out[name].publish(shot.messages[name])
            self._frame_done_out.publish(messages.header(stamp, self.get_name()))


def main(args=None):
    """Run the renderer node."""
    return run(Renderer, args)


if __name__ == '__main__':
    sys.exit(main())
