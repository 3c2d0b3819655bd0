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
from collections.abc import Collection, Mapping, Sequence
import contextlib
import sys
import time

from flag_sim.declarations.factories import Look, look_of
from flag_sim.declarations.images import picture_of, told_of
from flag_sim.declarations.objects import boxes_of, is_object
from flag_sim.declarations.picture_kernels import PICTURE_KERNELS
from flag_sim.declarations.pole_match import PoleMatch
from flag_sim.declarations.renderer import RENDERER
from flag_sim.declarations.scene import check_scene
from flag_sim.drawing import flag_scene, LastFrame, Picture
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.stamp_buffer import StampBuffer
from flag_sim.ros import camera_messages, serialized
from flag_sim.ros.cloud_reader import CloudReader
from flag_sim.ros.compiling import compiling
from flag_sim.ros.frame_node import FrameNode
from flag_sim.ros.kernel_switch import KernelSwitch
from flag_sim.ros.lifecycle import run
from flag_sim.ros.topics import DEPTH, publish, publishers, subscribe
import numpy as np

WIND_DISCOVERY_TIME = 1.0
"""
How long after its start the renderer waits for a wind to be discovered [s].

Vertices may come before the wind is discovered; after this time they are drawn without parameters,
as when they are played back alone.
"""
POLL_PERIOD = 5.0
"""
How often to check for a second publisher of vertices [s].

A publisher that was killed remains visible for less than that.
"""


class Drawing:
    """
    What a frame is drawn from, and the messages made of it so far, serialised.

    cloud: positions and normals; values: {parameter: value}; last: the frame before, or None.
    """

    def __init__(self, cloud: tuple[np.ndarray, np.ndarray | None], look: Look, values: Mapping,
                 last: LastFrame | None):
        self.cloud = cloud
        self.look = look
        self.values = values
        self.last = last
        self.is_drawn = False
        self.messages = {}

    def scene(self) -> list:
        """Return the objects to draw."""
        camera, _, materials, dimensions, _ = self.look
        return flag_scene(*self.cloud, camera, materials, dimensions, self.last)


class Renderer(FrameNode):
    """Publishes what the camera sees of every frame whose vertices and parameters came."""

    def __init__(self):
        super().__init__('renderer', RENDERER)
        self._values = self._look = None
        self._clouds = StampBuffer(DEPTH)  # positions and normals
        self._is_insisted = False  # whether the cloud that came last had come before
        self._first = None  # stamp of the take's first frame [ns]
        self._last = None, None  # FrameId and Drawing of the frame before
        self._known = set()  # channels that were drawn before
        self._pole_match = PoleMatch()
        with compiling(self, PICTURE_KERNELS.name(self.values)):
            PICTURE_KERNELS.warm_up(self.values)
        self._kernels = KernelSwitch(self, PICTURE_KERNELS, self.values, self._server.serve)
        self._tell_of_image(self.values, True)
        # Made after that, for the number of threads is chosen by how long its first frames take.
        self._picture = Picture(self.values['threads'])
        self._camera_out = {name: publish(self, name) for name in camera_messages.available()}
        self._frame_done_out = publish(self, 'frame_done')
        self._done = serialized.header(self.get_name())
        self._start = time.monotonic()
        self._reader = CloudReader()
        subscribe(self, 'vertices', self._on_vertices, raw=True)
        self._grace = self.create_timer(WIND_DISCOVERY_TIME, self._end_grace)
        self._publishers_timer = self.create_timer(POLL_PERIOD, self._look_for_publishers)
        self._had_several = False  # publishers of vertices, at the last look
        self._log.watch(self._missing, lambda: self._stopwatch.frames)
        self.get_logger().info(
            f'{self.values["width"]} x {self.values["height"]} pixels, waiting for vertices')

    def check(self, values: Mapping) -> None:
        """Raise ValueError for values that make no scene, a frame of no name, a broken image."""
        check_scene(values)
        boxes_of(values)
        if not values['camera.frame_id'].strip():
            raise ValueError('camera.frame_id must not be empty')
        picture_of(values['flag.image'])

    def check_asked(self, changes: Mapping) -> None:
        """Raise ValueError for an image that cannot be read now, also if it could be before."""
        picture_of(changes.get('flag.image', ''), is_asked=True)

    def apply(self, changed: Collection[str]) -> None:
        """Say what has become of the image."""
        self._tell_of_image(self.values, 'flag.image' in changed)

    def _tell_of_image(self, values, is_new):
        for words in told_of(values['flag.image'], is_new):
            self._log.warn(words, 'flag.image')

    is_part = staticmethod(is_object)

    # What arrives.

    def restart(self, frame: FrameId) -> None:
        """
        Forget the clouds of the take before; those of the frames that wait came early.

        Without a wind there are no takes, and none is forgotten.
        """
        self._first = frame.stamp
        self._kernels.restart()
        self._last = None, None
        if frame.take is not None:
            self._clouds.keep({early.stamp for early in self._server.order.waiting.values()})

    def is_ready(self, frame: FrameId) -> bool:
        """Return whether the frame's vertices have come, and it has kernels to be drawn with."""
        if frame.stamp not in self._clouds:
            return False
        _, keyed = self._server.inputs[frame]
        return self._kernels.may_serve(frame, {**self.values, **keyed})

    def _on_vertices(self, data, info):
        try:
            stamp, cloud = self._reader.read(data)
        except ValueError as error:
            self.refuse('vertices', error)
            return
        if self._server.is_served(stamp):
            # Only parameters tell their take: with takes this may be an early one of the next.
            if not self._server.order.has_takes:
                self._server.answer_again(stamp)
            return
        if stamp == self._first:
            self._clouds.keep(())  # they came late, from the take before
        self._is_insisted = stamp in self._clouds
        self._clouds.put(stamp, cloud)
        self._server.serve()
        if stamp in self._clouds:
            self._serve_alone(bytes(info['publisher_gid']['data']))

    def _serve_alone(self, sender):
        """Draw vertices without parameters, if no node could still send these."""
        is_early = time.monotonic() - self._start < WIND_DISCOVERY_TIME
        if is_early or self.count_publishers('parameters'):
            return
        for stamp in list(self._clouds):
            self.take_frame(FrameId(stamp, None, stamp, stamp), None, {}, sender)

    def _end_grace(self):
        self.destroy_timer(self._grace)
        self._serve_alone(None)

    # What is missing.

    def _missing(self):
        """Return in words what the next frame lacks: its vertices or, with them, parameters."""
        due, waiting = self._server.order.due, self._server.order.waiting
        if due is not None:  # it is not ready, else it had been drawn
            frame = f'vertices of the frame at {due.stamp / 1e9:.3f} s'
            senders = publishers(self, 'vertices')
            return (f'{frame}: {senders} has not sent them, its log says why' if senders else
                    f'{frame}: no node publishes them, is physics running?')
        senders = publishers(self, 'parameters')
        if waiting:
            after = min(waiting.values()).stamp
            return (f'parameters of a frame before the one at {after / 1e9:.3f} s, which says '
                    f'that they are owed: {senders or "no node"} publishes parameters')
        # A single cloud that came once may be a late copy, for which no parameters come.
        if (len(self._clouds) > 1 or (len(self._clouds) and self._is_insisted)) and senders:
            # Without any, the next one is drawn alone.
            return (f'parameters of the frame at {min(self._clouds) / 1e9:.3f} s, whose vertices '
                    f'have come: {senders} publishes parameters, but not '
                    'of this frame; end it, and vertices are drawn alone')
        return ''

    def _look_for_publishers(self):
        """Warn, once, of several publishers of vertices that are still there at the next look."""
        number = self.count_publishers('vertices')
        if number > 1 and self._had_several:
            self.get_logger().warning(
                f'{number} publishers of vertices ({publishers(self, "vertices")}): frames are '
                'drawn from one or the other')
            self.destroy_timer(self._publishers_timer)
        self._had_several = number > 1

    # The picture.

    def work(self, frame: FrameId, wind: np.ndarray, values: Mapping) -> Drawing:
        """Return the frame's Drawing, drawn if it has subscribers."""
        values = self._kernels.usable(values)
        if values != self._values:
            self._values, self._look = values, look_of(values)
            self._tell_of_image(values, False)
        drawing = Drawing(self._clouds.take(frame.stamp), self._look, values,
                          self._frame_before(frame))
        self._last = frame, drawing
        for entry in self._pole_match.update(drawing.cloud[0], values):
            self._log.write(entry)
        self._draw(frame.stamp, drawing, self._listened())
        return drawing

    def _frame_before(self, frame):
        """Return the LastFrame, or None after a gap and where another take begins."""
        last, drawing = self._last
        if last is None or frame.take is None or (
                (last.take, last.index + 1) != (frame.take, frame.index)):
            return None
        return LastFrame(drawing.cloud[0], drawing.look.camera, drawing.look.dimensions)

    def _listened(self):
        return [name for name, publisher in self._camera_out.items()
                if publisher.get_subscription_count()]

    def _draw(self, stamp, drawing, listened):
        """
        Make the messages that are listened to and not made yet.

        A frame is drawn once: a subscriber to depth that comes after it was drawn without depth
        gets the next one.
        """
        wanted = {name: camera_messages.TOPICS[name] for name in listened
                  if name not in drawing.messages}
        pictures = [topic.channels for topic in wanted.values() if topic.channels is not None]
        frame = None
        if pictures and not drawing.is_drawn:
            drawing.is_drawn = True
            camera, light, _, _, style = drawing.look
            channels = {channel for channels in pictures for channel in channels}
            before = drawing.last and drawing.last.camera
            with compiling(self, 'what the new channels need') if channels - self._known else (
                    contextlib.nullcontext()):
                frame = self._picture.draw_scene(drawing.scene(), camera, light, style, channels,
                                                 before)
            self._known |= channels
        shot = camera_messages.Shot(stamp, drawing.look.camera, self.values['camera.frame_id'],
                                    frame, drawing.cloud[0], drawing.values)
        for name, topic in wanted.items():
            if topic.channels is None or frame is not None:
                drawing.messages[name] = topic.message(shot)

    def answer(self, stamp: int, answer: Drawing) -> None:
        """Publish the picture and, if all of it has left, say that the frame is done."""
        listened = self._listened()
        self._draw(stamp, answer, listened)  # for who has begun to listen since it was served
        with self._stopwatch.measure('publish'):
            have_left = [self._camera_out[name].publish(answer.messages[name])
                         for name in listened if name in answer.messages]
            if all(have_left):  # else the wind asks again in lockstep
                self._frame_done_out.publish(self._done.at(stamp))

    def status(self) -> tuple[bytes, str, dict]:
        """Return the level, a message and the size of the pictures."""
        level, message, values = super().status()
        present = self._values or self.values
        return level, message, {**values, 'width [pixels]': present['width'],
                                'height [pixels]': present['height']}

    def close(self) -> None:
        """End what is compiled beside; log where the time went."""
        self._kernels.close()
        super().close()


def main(args: Sequence[str] | None = None) -> int:
    """Run the renderer node; return the exit status."""
    return run(Renderer, args)


if __name__ == '__main__':
    sys.exit(main())
