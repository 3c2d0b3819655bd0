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

"""All forces on the nodes (1.6): one call for each, none for those whose coefficient is zero."""
import math
from typing import NamedTuple

from flag_sim.cloth.aerodynamics import add_faces, wind_on_faces
from flag_sim.cloth.bending import add_moments, set_moments
from flag_sim.cloth.collision import Contact, Limits
from flag_sim.cloth.material import Air
from flag_sim.cloth.springs import damped_tensions, elastic_tensions, sum_tensions
from flag_sim.jit.kernels import shared_kernel
from flag_sim.parallel.barrier import new_barrier, wait
import numpy as np

NO_POLE = (0.0, 0.0, 0.0)
"""A pole of radius zero, which nothing can be inside of."""


class Forcing(NamedTuple):
    """What acts on the cloth from outside."""

    wind: tuple = (0.0, 0.0, 0.0)  # [m/s]
    gravity: float = 9.81          # [m/s2], along -z
    air: Air = Air()
    pole: tuple = NO_POLE          # as x, y and radius of a cylinder; measured as positions [m]
    stretch_limit: float = math.inf  # of a node's way from the hoist; held in steps with a pole


class Coefficients(NamedTuple):
    """The numbers of every force, and the limits, ready for the kernels."""

    spring_k: tuple     # across, down, diagonal [N/m]
    spring_c: tuple     # the dashpots of the same [N s/m]
    spring_rest: tuple  # the lengths at rest of the same [m]
    bend: tuple         # across, down, twist [N/m]
    gravity: float      # g [m/s2]
    drag: float         # of Air [kg/m3]
    drag_rate: float    # the same over a face's mass [1/m3]
    law: int            # of the wind: pressure.QUADRATIC, LINEAR or SEED
    order: int          # of the method, to which drag is kept from overshooting
    node_damping: float  # nu [1/s]
    limits: Limits      # where nodes may be


class Work(NamedTuple):
    """Flat arrays that the forces are computed in; nothing is kept in them between steps."""

    force: tuple     # x, y, z [N]
    tensions: tuple  # across, down, rising, falling [N/m]
    moments: tuple   # across, down, twist [N], for each axis
    faces: tuple     # x, y, z of half the force on upper, then on lower faces [N]
    contact: Contact  # with the pole
    barrier: np.ndarray  # of the threads that share the steps

    @classmethod
    def of(cls, mesh):
        """Return the work arrays of a mesh. All zero: ghosts must be, and stay so."""
        def arrays(count):
            return tuple(mesh.fields(count))

        return cls(arrays(3), arrays(4), (arrays(3), arrays(3), arrays(3)), arrays(6),
                   Contact.of(mesh), new_barrier(1))


@shared_kernel
def set_parts(position, velocity, wind, weights, coefficients, work, dt, span):
    """
    Set work's tensions, moments and faces: what acts between the nodes of span and those after.

    dt: the step that the wind is taken implicitly over [s]; zero for its momentary force. All
    threads of work.barrier call it together and leave together, each with the nodes of its span.
    """
    k, c, rest = coefficients.spring_k, coefficients.spring_c, coefficients.spring_rest
    if max(c) > 0.0:
        damped_tensions(position, velocity, weights, k, c, rest, work.tensions, span)
    else:
        elastic_tensions(position, weights, k, rest, work.tensions, span)
    if max(coefficients.bend) > 0.0:
        set_moments(position, weights, coefficients.bend, work.moments, span)
    if coefficients.drag > 0.0:
        wind_on_faces(position, velocity, wind, coefficients.drag, dt * coefficients.drag_rate,
                      coefficients.law, coefficients.order, weights, work.faces, span)
    wait(work.barrier)


@shared_kernel
def set_forces(position, velocity, wind, mass, weights, coefficients, work, dt, span):
    """Set work.force [N] to the sum of all forces on each node but its own damping (1.6)."""
    set_parts(position, velocity, wind, weights, coefficients, work, dt, span)
    sum_tensions(position, work.tensions, mass, coefficients.gravity, work.force, span)
    if max(coefficients.bend) > 0.0:
        add_moments(work.moments, work.force, span)
    if coefficients.drag > 0.0:
        add_faces(work.faces, work.force, span)
