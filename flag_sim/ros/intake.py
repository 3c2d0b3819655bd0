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

"""What stands between a subscription, or a service, and its callback."""
import collections
from collections.abc import Callable
import inspect
import time
from typing import NamedTuple

from rclpy.serialization import deserialize_message

LONGEST_QUEUE = 100_000_000
"""How old a message may be that is served before all that came meanwhile [ns]."""
KEPT = 8
"""Messages of a topic that wait for their turn; of more the latest, as in the middleware."""

KEPT_REQUESTS = 100
"""Requests to a service that wait for their turn; of more the latest."""


class Intake:
    """
    The callback that an executor calls with the serialised messages of a topic.

    node: a GuardedNode; callback: gets a message of `message_type`, or its bytes where is_raw, and
    the message's info if it takes two arguments. What is no such message, and what the callback
    raises, is reported by the node and goes no further.

    The events of an executor in C++ stand in one queue. On a topic that is sent faster than it is
    served they would keep all others waiting, longer and longer. So where messages grow old in
    that queue they are taken out of it first, and then served in turn with the other topics.
    """

    # By this rclpy knows that there are two arguments.
    __signature__ = inspect.signature(lambda message, info: None)

    def __init__(self, node: object, message_type: type, topic: str, callback: Callable,
                 is_raw: bool):
        self._node = node
        self._type = message_type
        self._topic = topic
        self._callback = callback
        self._is_raw = is_raw
        self._takes_info = _takes_two(callback)
        self._waiting = collections.deque(maxlen=KEPT)
        self._is_scheduled = False

    def __call__(self, *arguments: object) -> None:
        """Serve a message now or, where messages have waited for long, in its turn."""
        # The EventsExecutor of rclpy 9.1.2 gives both as one tuple, the other executors as two.
        data, info = arguments if len(arguments) == 2 else arguments[0]
        defer = self._node.defer
        if defer is None or not self._waiting and _age(info) < LONGEST_QUEUE:
            self._serve(data, info)
            return
        self._waiting.append((data, info))
        if not self._is_scheduled:
            self._is_scheduled = True
            defer(self._serve_next)

    def _serve_next(self):
        self._is_scheduled = False
        if self._waiting:
            self._serve(*self._waiting.popleft())
        if self._waiting:
            self._is_scheduled = True
            self._node.defer(self._serve_next)

    def _serve(self, data, info):
        try:
            message = data if self._is_raw else self._read(data)
            if self._takes_info:
                self._callback(message, info)
            else:
                self._callback(message)
        except Exception as error:
            self._node.report(error)

    def _read(self, data):
        try:
            return deserialize_message(data, self._type)
        except RuntimeError:  # of the middleware; it names a line in its source
            raise ValueError(f'{len(data)} bytes on {self._topic} are no '
                             f'{self._type.__name__}') from None


class Later(NamedTuple):
    """In place of an answer: what it is to be made from, in its turn."""

    request: object
    response: object


class RequestIntake:
    """
    The callback of a service, and what sends its answers in place of rclpy's own.

    node: a GuardedNode; answer(request, response): returns the answer. As of messages, a flood of
    requests keeps nothing else waiting: one is served each time that the queue of the executor
    has gone round.
    """

    def __init__(self, node: object, answer: Callable):
        self._node = node
        self._answer = answer
        self._send = None
        self._waiting = collections.deque(maxlen=KEPT_REQUESTS)
        self._is_scheduled = False

    def attach(self, service: object) -> None:
        """Send the answers of an rclpy service, whose callback this is."""
        self._send, service.send_response = service.send_response, self._send_response

    def __call__(self, request: object, response: object) -> object:
        """Return the answer, or a Later where a request was served already in this round."""
        if self._node.defer is None:
            return self._answer(request, response)
        if self._is_scheduled:
            return Later(request, response)
        self._schedule()
        return self._answer(request, response)

    def _schedule(self):
        self._is_scheduled = True
        self._node.defer(self._serve_next)

    def _send_response(self, response, header):
        if isinstance(response, Later):
            self._waiting.append((response, header))
        else:
            self._send(response, header)

    def _serve_next(self):
        self._is_scheduled = False
        if not self._waiting:
            return
        later, header = self._waiting.popleft()
        self._schedule()
        try:
            self._send(self._answer(*later), header)
        except Exception as error:
            self._node.report(error)


def _age(info):
    """Return how long ago a message was received [ns]."""
    return time.time_ns() - info['received_timestamp']


def _takes_two(callback):
    """Return whether a callback takes a message's info too, as rclpy finds it out."""
    signature = inspect.signature(callback)
    try:
        signature.bind(None)
    except TypeError:
        signature.bind(None, None)
        return True
    return False
