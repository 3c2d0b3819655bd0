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

"""A solver whose kernels are not kept: compiled beside a node whose frames go on, or wait."""
import time
from unittest import mock

from flag_sim.cloth import Cloth
from flag_sim.declarations.kernel_choice import KernelChoice
from flag_sim.jit.beside import CompilingProcess
from flag_sim.nodes.renderer import Renderer
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import kernel_switch, messages
import numpy as np
import pytest
import rclpy
from rclpy.parameter import Parameter
from support.bench import Bench, WIND
from support.frames import parameters_message

FRAME = 1.0 / 30.0
WAITING = 'import os, time\nwhile not os.path.exists({!r}): time.sleep(0.01)'


@pytest.fixture
def bench(domain):
    """Return a physics node with its default parameters."""
    with rclpy.init(domain_id=domain):
        bench = Bench(waits=False)
        yield bench
        bench.node.close()
        bench.close()


@pytest.fixture
def keep(monkeypatch, tmp_path):
    """Have no further kernels kept until this is called: a process seems to compile them."""
    path = tmp_path / 'kept'
    load = KernelChoice.load
    monkeypatch.setattr(KernelChoice, 'load',
                        lambda choice, values: path.exists() and load(choice, values))
    monkeypatch.setattr(KernelChoice, 'program',
                        lambda choice, values: WAITING.format(str(path)))
    return path.touch


def stamp_of(n):
    """Return the stamp of frame n [ns]."""
    return round(n * FRAME * 1e9)


def send(bench, n, oldest):
    """Let frame n arrive, whose sender waits for frames from `oldest` on."""
    bench.hear(parameters_message('/wind', FrameId(stamp_of(n), 1, n, oldest), WIND, {}))


def heard(bench):
    """Return the positions that the node has sent."""
    return [messages.read_cloud(cloud)[0] for cloud in bench.clouds]


def spin_until(bench, condition):
    """Spin the node until the condition holds."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        rclpy.spin_once(bench.node, timeout_sec=0.05)


def library(frames):
    """Return positions by the library, frame by frame: each (number, solver)."""
    cloth, before, positions = Cloth(pole=(0.0, 0.0, 0.05)), None, []
    for n, solver in frames:
        cloth.solver = solver
        if before is not None:
            cloth.advance((stamp_of(n) - stamp_of(before)) * 1e-9, WIND)
        before = n
        positions.append(cloth.positions.astype(np.float32))
    return positions


def test_in_real_time_frames_go_on_with_the_old_solver(bench, keep, capfd):
    """One is left out, which may have been of lockstep; the log says what happens."""
    for n in range(4):
        send(bench, n, n)
    assert bench.put(solver='verlet').successful
    for n in range(4, 8):
        send(bench, n, n)
    said = capfd.readouterr().err
    assert 'compiling solver verlet in float64 in a process beside' in said
    assert said.count('frames in real time go on with solver symplectic in float64') == 1
    keep()
    logged = []
    spin_until(bench, lambda: logged.append(capfd.readouterr().err)
               or 'solver verlet in float64 takes over' in ''.join(logged))
    send(bench, 8, 8)
    turns = [*((n, 'symplectic') for n in (0, 1, 2, 3, 5, 6, 7)), (8, 'verlet')]
    assert np.array_equal(heard(bench), library(turns))


def test_in_lockstep_frames_wait_for_the_new_solver(bench, keep):
    """However many are under way, so that two runs of a shot are the same to the byte."""
    for n in range(4):
        send(bench, n, n)
    assert bench.put(solver='verlet').successful
    for n in (4, 5, 6, 4):  # the oldest once more, as it is not done
        send(bench, n, 4)
    assert len(bench.clouds) == 4
    keep()
    spin_until(bench, lambda: len(bench.clouds) == 7)
    turns = [*((n, 'symplectic') for n in range(4)), *((n, 'verlet') for n in (4, 5, 6))]
    assert np.array_equal(heard(bench), library(turns))


def test_the_renderer_draws_in_the_old_style_meanwhile(domain, keep):
    """So far as other kernels are needed; what else was set counts at once."""
    with rclpy.init(domain_id=domain):
        renderer = Renderer()
        flag = Cloth(3, 4).positions
        drawn = []

        def send(n):
            renderer._clouds.put(stamp_of(n), (flag, None))
            renderer.take_frame(FrameId(stamp_of(n), 1, n, n), None, {}, 'wind')
            if renderer._server.is_served(stamp_of(n)):
                drawn.append((n, renderer._values['outline'], renderer._values['ambient']))

        send(0)
        for name, value in (('outline', True), ('ambient', 0.5)):
            assert renderer.set_parameters_atomically([Parameter(name, value=value)]).successful
        for n in (1, 2, 3):
            send(n)
        keep()
        end = time.monotonic() + 60.0
        while renderer._kernels.is_compiling and time.monotonic() < end:
            rclpy.spin_once(renderer, timeout_sec=0.05)
        send(4)
        renderer.close()
        renderer.destroy_node()
    assert drawn == [(0, False, 0.35), (2, False, 0.5), (3, False, 0.5),
                     (4, True, 0.5)]


def test_where_nothing_is_kept_the_node_compiles_by_itself(bench, monkeypatch):
    """And goes on; so it does where the process was killed."""
    monkeypatch.setattr(KernelChoice, 'load', lambda choice, values: False)
    monkeypatch.setattr(KernelChoice, 'program', lambda choice, values: 'raise SystemExit(1)')
    send(bench, 0, 0)
    assert bench.put(solver='verlet').successful
    send(bench, 1, 1)
    spin_until(bench, lambda: len(bench.clouds) == 2)
    assert np.array_equal(heard(bench), library([(0, 'symplectic'), (1, 'verlet')]))


def test_another_switch_replaces_the_one_that_is_compiled(bench, keep):
    """The one back to what is there at once; the process before is ended."""
    send(bench, 0, 0)
    processes = []
    for solver in ('verlet', 'rk4'):
        assert bench.put(solver=solver).successful
        send(bench, 1, 1)
        processes.append(bench.node._kernels._process)
    assert [process.is_over for process in processes] == [True, False]
    assert bench.put(solver='symplectic').successful
    send(bench, 1, 1)
    assert np.array_equal(heard(bench), library([(0, 'symplectic'), (1, 'symplectic')]))
    bench.node.close()
    assert processes[1].is_over


def test_the_process_keeps_what_it_compiles(tmp_path):
    """It runs its program to the end, and imports what this process can."""
    path = tmp_path / 'done'
    process = CompilingProcess(
        f'import flag_sim.cloth, pathlib; pathlib.Path({str(path)!r}).touch()')
    end = time.monotonic() + 60.0
    while not process.is_over and time.monotonic() < end:
        time.sleep(0.01)
    assert path.exists()
    process.end()


def test_what_is_wanted_after_others_were_ready_is_held_anew(monkeypatch):
    """Frames of real time have passed before; those of lockstep, later, wait all the same."""
    monkeypatch.setattr(kernel_switch, 'CompilingProcess', mock.Mock())
    choice = mock.Mock(chosen=dict, load=lambda values: False, program=str)
    choice.name = lambda values: values['solver']
    old, new = {'solver': 'old'}, {'solver': 'new'}
    switch = kernel_switch.KernelSwitch(mock.Mock(), choice, old, mock.Mock())

    def asked(index, oldest, values):
        return switch.may_serve(FrameId(index * 10, 1, index, oldest), values)
    assert [asked(n, n, new) for n in (4, 5, 6)] == [False, True, True]
    assert asked(7, 7, old)
    assert not any(asked(n, oldest, new) for n, oldest in ((18, 18), (19, 18), (20, 18)))
