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

"""
What passes between the thread of the window and the thread of ROS.

Either side leaves what it has and wakes the other; neither ever waits for the other.
"""
import collections
from collections.abc import Callable
import dataclasses
import threading

from flag_sim.parameters.descriptor import Descriptor
from flag_sim.protocol.cdr_image import ImageBytes

PLACES = 64
"""Frames that may be announced before the picture of the first of them has come."""

# To the window.


@dataclasses.dataclass(frozen=True)
class Found:
    """Who plays each role in the graph: {role: full name of a node}; who is gone is left out."""

    nodes: dict[str, str]


@dataclasses.dataclass(frozen=True)
class Described:
    """All parameters of a node."""

    node: str
    descriptors: tuple[Descriptor, ...]
    values: dict[str, object]


@dataclasses.dataclass(frozen=True)
class Changed:
    """Parameters of a node that have been set, by whomever; deleted: names that are no more."""

    node: str
    values: dict[str, object]
    deleted: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class Answered:
    """What came of a SetParameters: why each name was refused, '' where it is set."""

    token: int
    reasons: dict[str, str]


@dataclasses.dataclass(frozen=True)
class Reported:
    """What a node says of itself on `state`."""

    node: str
    is_ok: bool
    message: str
    values: dict[str, str]


@dataclasses.dataclass(frozen=True)
class Unreadable:
    """Why the last image cannot be read."""

    reason: str


@dataclasses.dataclass(frozen=True)
class FramePlace:
    """A frame that the wind has announced; stamp [ns]; take and index: None where unknown."""

    stamp: int
    take: int | None
    index: int | None


# To ROS.


@dataclasses.dataclass(frozen=True)
class SetParameters:
    """Set parameters of a node; a value None deletes. together: all of them or none."""

    token: int
    node: str
    values: dict[str, object]
    descriptors: dict[str, Descriptor]
    together: bool = False


@dataclasses.dataclass(frozen=True)
class Publish:
    """Send an empty message on a topic: reset or step."""

    topic: str


class Exchange:
    """
    Two boxes, and a place for the latest picture.

    wake_window, wake_ros: set by each side; called in the other's thread when something was left,
    once until it is taken. A picture that nobody has taken when the next comes is left out, and
    counted: pictures never queue.
    """

    def __init__(self):
        self.wake_window: Callable[[], None] | None = None
        self.wake_ros: Callable[[], None] | None = None
        self._lock = threading.Lock()
        self._news = collections.deque()
        self._places = {}  # {stamp: FramePlace} of the latest frames; of the side of ROS alone
        self._picture = None
        self._requests = collections.deque()
        self._is_window_woken = False
        self.left_out = 0

    # The side of ROS.

    def post(self, news: object) -> None:
        """Leave news for the window."""
        with self._lock:
            self._news.append(news)
        self._wake_window()

    def put_place(self, place: FramePlace) -> None:
        """Leave the place of a frame, whose picture is to come."""
        self._places[place.stamp] = place
        while len(self._places) > PLACES:
            del self._places[next(iter(self._places))]

    def put_picture(self, picture: ImageBytes) -> None:
        """Leave the latest picture."""
        with self._lock:
            self.left_out += self._picture is not None
            self._picture = picture, self._places.get(picture.stamp)
        self._wake_window()

    def requests(self) -> list:
        """Take what the window asks for."""
        with self._lock:
            taken = [*self._requests]
            self._requests.clear()
        return taken

    def _wake_window(self):
        with self._lock:
            is_woken, self._is_window_woken = self._is_window_woken, True
        if not is_woken and self.wake_window is not None:
            self.wake_window()

    # The side of the window.

    def ask(self, request: object) -> None:
        """Leave a request for ROS."""
        with self._lock:
            self._requests.append(request)
        if self.wake_ros is not None:
            self.wake_ros()

    def news(self) -> tuple[list, tuple[ImageBytes, FramePlace | None] | None]:
        """Take all news, and the latest picture with its frame's place if there is a new one."""
        with self._lock:
            self._is_window_woken = False
            taken = [*self._news]
            self._news.clear()
            picture, self._picture = self._picture, None
        return taken, picture
