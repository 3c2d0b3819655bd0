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
Programs that take turns: each in a process of its own, none at work but the one whose turn it is.

So that no program's threads, caches of code or settings of the processor meet another's, and a
program that crashes is named instead of ending the benchmark.
"""
import importlib
import multiprocessing
import os
import time


class Missing(Exception):
    """A program cannot be measured; the text says why."""


def _serve(pipe, module, arguments, processors):
    """Make the module's Peer and do what the pipe asks for: a number of steps, or the state."""
    os.sched_setaffinity(0, processors)
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    try:
        peer = importlib.import_module(module).Peer(**arguments)
        pipe.send(peer.precision)
        while (request := pipe.recv()) is not None:
            if request == 'state':
                pipe.send(peer.state())
                continue
            begin = time.perf_counter()
            peer.run(request)
            pipe.send(time.perf_counter() - begin)
    except Exception as error:  # whatever hinders a peer is named by the table, not hidden
        pipe.send(Missing(f'{type(error).__name__}: {error}'.splitlines()[0]))


class Program:
    """
    A peer's process, to be used in a with statement.

    module: where its Peer is; arguments: what that is made from; processors: where it may run.
    Every call raises Missing if the program cannot answer.
    """

    def __init__(self, module, arguments, processors):
        context = multiprocessing.get_context('spawn')
        self._pipe, far = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(far, module, arguments, processors), daemon=True)
        self._process.start()
        far.close()  # so that the end of the process ends the pipe
        self.precision = self._receive()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.join()

    def run(self, steps):
        """Take steps; return how long they took [s]."""
        self._pipe.send(steps)
        return self._receive()

    def state(self):
        """Return positions and velocities."""
        self._pipe.send('state')
        return self._receive()

    def _receive(self):
        try:
            answer = self._pipe.recv()
        except EOFError:
            self._process.join()
            raise Missing(f'its process ended with {self._process.exitcode}') from None
        if isinstance(answer, Missing):
            raise answer
        return answer
