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

"""The physics node: moves the cloth to the time of every frame and publishes its vertices."""
import math
import sys
import time

from flag_sim.cloth import energy
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.simulation import Cloth, Diverged, MAX_WIND
from flag_sim.cloth.strain import greatest_strain
from flag_sim.declarations.making import (
    air_of, cloth_of, hang_of, material_of, pole_of, stepping_of)
from flag_sim.declarations.nodes import PHYSICS, SCENE
from flag_sim.jit.cache import compilations
from flag_sim.parameters import checks
from flag_sim.ros import messages
from flag_sim.ros.compiling import compiling
from flag_sim.ros.diagnostics import ERROR, WARN
from flag_sim.ros.frame_node import FrameNode
from flag_sim.ros.hysteresis import Hysteresis
from flag_sim.ros.lifecycle import run
from flag_sim.ros.throttled_log import WARN_EVERY
from flag_sim.ros.topics import publish

CALM = 2.0
"""Seconds of simulated time without it after which softening or refining of steps is over."""
PREROLL_FRAME = 1.0 / 30.0
"""Longest piece of a pre-roll [s], an ordinary frame: `substeps_limit` goes by the frame."""


def kernels_of(values):
    """Return in words what the kernels are compiled for."""
    return f'solver {values["solver"]} in {values["precision"]}'


class Physics(FrameNode):
    """
    Publishes `vertices` for every frame that `parameters` announces.

    A frame's wind and values hold for the whole time from the frame before to it (a zero-order
    hold), so where they change the motion depends on `rate`, to first order in its period.

    A cloth that begins anew (in a take's first frame, and of another size) first moves for
    `preroll` seconds in that frame's wind, so it depends on nothing but this frame and the
    parameters: it is the same in lockstep, in real time, after a reset and from a bag.
    """

    def __init__(self):
        super().__init__('physics', SCENE + PHYSICS)
        self._time = None  # stamp that the cloth stands at [ns]; None: before any frame
        self._is_new = True  # whether the cloth was just laid out, and has not moved since
        self._plan = None  # how the last frame was divided into steps
        self._refined = Hysteresis(CALM)
        self._softened = Hysteresis(CALM)
        self._held = 0  # nodes that stretch_limit held back in the last frame
        self._diverged = ''  # why the last frame could not be simulated
        self._busy = 0.0, ''  # how long the last frame took [s]; what was compiled or loaded then
        self._applied = dict(self.values)
        self._cloth = cloth_of(self.values)
        self._warm_up(self.values)
        self._vertices_out = publish(self, 'vertices')
        self.get_logger().info(
            f'{self.values["grid.columns"]} x {self.values["grid.rows"]} nodes, '
            'waiting for frames')

    def _warm_up(self, values):
        """
        Compile or load the kernels before the first frame that needs them.

        Those of one solver and precision only: all would take more memory and a minute more.
        """
        with compiling(self, kernels_of(values)):
            cloth = Cloth(3, 3, pole=(0.0, 0.0, 0.01), solver=values['solver'],
                          precision=values['precision'])
            cloth.advance(1e-3)
            cloth.normals()

    def check(self, values):
        """Refuse values of which no cloth can be made."""
        material_of(values), air_of(values), stepping_of(values)
        if values['pole.diameter'] >= values['pole.height']:
            diameter, height = (checks.text(values[f'pole.{n}']) for n in ('diameter', 'height'))
            raise ValueError(f'pole.diameter {diameter} m must be less than pole.height '
                             f'{height} m')
        _, length, width = hang_of(values)
        try:
            Mesh(2, 2, length, width)  # refuses a size that no grid has
        except ValueError as error:
            raise ValueError(f'flag.{error}') from None

    def check_wind(self, wind):
        """Refuse a wind that the cloth does not take."""
        checks.vector('wind', wind, MAX_WIND)

    def restart(self, frame):
        """Lay the cloth out again."""
        del frame
        self._cloth.reset()
        self._is_new = True
        self._time = None
        self._diverged = ''

    def work(self, frame, wind, values):
        """Return the frame's PointCloud2."""
        begin = time.monotonic()
        kernels, before = kernels_of(self._applied), compilations()
        if self._time is None and frame.take is not None and frame.index > 0:
            state = 'from its preroll' if values['preroll'] > 0.0 else 'at rest'
            self.get_logger().warning(f'joined the take at frame {frame.index}: the cloth begins '
                                      f'{state} there; reset for a whole take',
                                      throttle_duration_sec=WARN_EVERY)
        if self._time is not None and frame.stamp < self._time:
            self.restart(frame)
        if values != self._applied:
            self._configure(values)
        if self._is_new:
            self._roll(values['preroll'], wind)
        if self._time is not None:
            self._advance((frame.stamp - self._time) * 1e-9, wind)
        self._time = frame.stamp
        prepared = ''
        if kernels_of(values) != kernels:
            doing = 'compiling' if compilations() > before else 'loading'
            prepared = f'{doing} {kernels_of(values)}'
        self._busy = time.monotonic() - begin, prepared
        return messages.cloud_message(frame.stamp, self._cloth.positions, self._cloth.normals())

    def _configure(self, values):
        """Bring the cloth to this frame's values; only another size starts it anew."""
        before, self._applied = self._applied, values
        self._cloth.start_noise = values['start_noise']
        self._cloth.start_seed = values['start_seed']
        if hang_of(values) != hang_of(before):
            self._cloth.pole = None  # the hoist may be where the old one stood
            self._cloth.hang(*hang_of(values))
            self._is_new = True
        grid = values['grid.rows'], values['grid.columns']
        if grid != (before['grid.rows'], before['grid.columns']):
            self._cloth.regrid(*grid)
        if kernels_of(values) != kernels_of(before):
            self._warm_up(values)
        self._cloth.material = material_of(values)
        self._cloth.air = air_of(values)
        self._cloth.gravity = values['gravity']
        self._cloth.stepping = stepping_of(values)
        self._cloth.solver = values['solver']
        self._cloth.stretch_limit = values['stretch_limit']
        self._cloth.pole = pole_of(values)
        self._cloth.precision = values['precision']

    def _roll(self, seconds, wind):
        """Move a cloth that was just laid out for so long in a steady wind, with no frame sent."""
        self._is_new = False
        pieces = math.ceil(seconds / PREROLL_FRAME)
        for _ in range(pieces):
            if not self.context.ok():  # Ctrl-C: a fine grid takes a while
                return
            self._move(seconds / pieces, wind)

    def _advance(self, dt, wind):
        if dt > self._applied['max_gap']:
            gap = (f'{dt:.3f} s between two frames is more than max_gap = '
                   f'{self._applied["max_gap"]:g} s: the cloth stands still over them; '
                   f'{self._cause_of_gap(dt)}')
            if self._refusals.is_worth_saying(gap, time.monotonic()):
                self.get_logger().warning(gap)
        elif dt > 0.0:
            self._move(dt, wind)

    def _move(self, dt, wind):
        """Move the cloth by dt [s] and tell of what its user should know."""
        try:
            self._plan = self._cloth.advance(dt, wind)
            self._diverged = ''
            self._report(self._plan, dt)
        except Diverged as error:
            self._diverged = str(error)
            self.get_logger().error(self._diverged, throttle_duration_sec=WARN_EVERY)

    def _cause_of_gap(self, dt):
        """Return in words why no frame was served for so long, or what can be done about it."""
        seconds, prepared = self._busy
        if seconds < 0.5 * dt:  # they were not sent, or not by this clock
            return 'a greater max_gap would simulate them'
        return (f'physics itself was busy for {seconds:.1f} s'
                + (f', {prepared}' if prepared else ' with the frame before'))

    def _report(self, plan, dt):
        """Say when steps or cloth begin to be other than they are set, and when that is over."""
        asked = self._applied['substeps']
        begins, ends = self._refined.see(0 < asked < plan.granted, dt)
        if begins:
            self.get_logger().warning(
                f'substeps = {asked} is not stable: the frame needs {plan.demanded} steps and '
                f'gets {plan.granted}')
        elif ends:
            self.get_logger().info('frames get the steps that substeps sets again')
        begins, ends = self._softened.see(_is_softened(plan), dt)
        if begins:
            self.get_logger().warning(
                f'the frame needs {plan.demanded} steps and substeps_limit allows {plan.granted}: '
                f'stiffness is lowered to {plan.stiffness_factor:.3g} and damping to '
                f'{plan.damping_factor:.3g} of what is set; a greater substeps_limit avoids it')
        elif ends:
            self.get_logger().info('stiffness and damping are as they are set again: the frame '
                                   f'needs {plan.demanded} steps and gets {plan.granted}')
        if self._cloth.held and not self._held:
            self.get_logger().warning(
                f'{self._cloth.held} nodes would stretch the cloth beyond stretch_limit = '
                f'{self._applied["stretch_limit"]:g} and are held back',
                throttle_duration_sec=WARN_EVERY)
        self._held = self._cloth.held

    def status(self):
        """Return the level, a message and what the cloth and its steps are like."""
        level, message, _ = super().status()
        is_softened = self._plan is not None and _is_softened(self._plan)
        if self._diverged:
            level, message = ERROR, self._diverged
        elif is_softened or self._held:
            level, message = WARN, ' and '.join(
                ['the cloth is softer than it is set'] * is_softened
                + [f'{self._held} nodes are held back by stretch_limit'] * bool(self._held))
        model, positions = self._cloth.model, self._cloth.positions
        values = {
            'kinetic energy [J]': energy.kinetic_energy(model, self._cloth.velocities),
            'elastic energy [J]': (energy.elastic_energy(model, positions)
                                   + energy.bending_energy(model, positions)),
            'greatest strain': greatest_strain(model.mesh, positions),
            'nodes held by stretch_limit': self._held}
        if self._plan is not None:
            demanded, granted, stiffness, damping = self._plan
            values |= {'steps demanded': demanded, 'steps granted': granted,
                       'stiffness factor': stiffness, 'damping factor': damping}
        return level, message, values

    def answer(self, stamp, cloud):
        """Publish the frame's vertices."""
        with self._stopwatch.share('publish'):
            self._vertices_out.publish(cloud)


def _is_softened(plan):
    """Return whether a frame's cloth was softer or less damped than it is set."""
    return min(plan.stiffness_factor, plan.damping_factor) < 1.0


def main(args=None):
    """Run the physics node."""
    return run(Physics, args)


if __name__ == '__main__':
    sys.exit(main())
