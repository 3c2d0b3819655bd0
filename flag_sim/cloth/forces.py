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

"""All forces on the nodes (eq. 1.6); a force whose coefficient is zero is not computed."""
import math
from typing import NamedTuple

from flag_sim.cloth.aerodynamics import add_wind_forces, set_face_forces, Wind
from flag_sim.cloth.bending import add_bending_forces, set_moments
from flag_sim.cloth.contact import Contact, Limits, NO_POLE
from flag_sim.cloth.material import Air
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Band, Field, Nodes, Sheet, Vector, Weights
from flag_sim.cloth.springs import (
    damped_tensions, elastic_tensions, set_springs_and_weight, set_weight, Springs)
from flag_sim.jit.kernels import shared_kernel
from flag_sim.parallel.barrier import new_barrier, wait
import numpy as np


class Forcing(NamedTuple):
    """What acts on the cloth from outside, as its users give it."""

    wind: Vector = (0.0, 0.0, 0.0)   # [m/s]
    gravity: float = 9.81            # [m/s2], against up
    air: Air = Air()
    pole: Vector = NO_POLE           # x, y and radius of a cylinder [m]; measured as positions
    stretch_limit: float = math.inf  # see Limits.of
    up: Vector = (0.0, 0.0, 1.0)     # a unit vector
    spin: Vector = (0.0, 0.0, 0.0)   # of the pole, in whose frame all of this is [rad/s]
    lever: Vector = (0.0, 0.0, 0.0)  # from what it turns about to the positions' origin [m]
    drift: Vector = (0.0, 0.0, 0.0)  # the pole's velocity, where wind is not past the pole [m/s]


class Coefficients(NamedTuple):
    """The numbers of every force, and the limits, ready for kernels: a Model under a Forcing."""

    springs: Springs
    bend: Vector         # across, down, twist [N/m]; all zero: no bending
    gravity: Vector      # g times a unit vector upwards [m/s2]
    wind: Wind
    node_damping: float  # nu [1/s]; the method's own to take account of
    limits: Limits       # where nodes may be


class Work(NamedTuple):
    """Flat arrays that the forces are computed in; nothing is kept in them between steps."""

    force: Field         # x, y, z [N]
    tensions: tuple      # across, down, rising, falling [N/m]
    moments: tuple       # across, down, twist [N], for each axis
    faces: tuple         # x, y, z of half the force on upper, then on lower faces [N]
    contact: Contact     # with the pole
    barrier: np.ndarray  # of the threads that compute the steps

    @classmethod
    def of(cls, mesh: Mesh) -> 'Work':
        """Return the work arrays of a mesh. All zero: ghosts must be, and stay so."""
        def arrays(count):
            return tuple(mesh.fields(count))

        return cls(arrays(3), arrays(4), (arrays(3), arrays(3), arrays(3)), arrays(6),
                   Contact.of(mesh), new_barrier(1))


@shared_kernel
def begin_element_forces(nodes: Nodes, weights: Weights, coefficients: Coefficients, work: Work,
                         dt: float, band: Band) -> None:
    """
    Set the tensions, bending moments and wind forces that begin at the nodes of a band.

    These are the forces of the elements: of springs, of the plate and of faces. They are written
    to work.tensions, work.moments and work.faces.

    dt: the step that the wind is taken implicitly over [s]; zero for its momentary force.
    """
    # Tension of the springs (eq. 1.2), with or without dashpots.
    if max(coefficients.springs.c) > 0.0:
        damped_tensions(nodes, weights, coefficients.springs, work.tensions, band)
    elif max(coefficients.springs.k) > 0.0:
        elastic_tensions(nodes.position, weights, coefficients.springs, work.tensions, band)
    # Moments of bending.
    if max(coefficients.bend) > 0.0:
        set_moments(nodes.position, weights, coefficients.bend, work.moments, band)
    # Force of the wind on each face (eq. 1.3).
    if coefficients.wind.drag > 0.0:
        set_face_forces(nodes, coefficients.wind, dt, weights, work.faces, band)


@shared_kernel
def set_element_forces(nodes: Nodes, weights: Weights, coefficients: Coefficients, work: Work,
                       dt: float, band: Band) -> None:
    """
    Do as begin_element_forces, and wait for the other threads' elements.

    All threads of work.barrier call it together and leave together, each with the nodes of its
    band.
    """
    begin_element_forces(nodes, weights, coefficients, work, dt, band)
    wait(work.barrier)


@shared_kernel
def set_forces(nodes: Nodes, sheet: Sheet, coefficients: Coefficients, work: Work, dt: float,
               band: Band) -> None:
    """
    Set work.force [N] to the sum of all forces on each node of a band (eq. 1.6).

    The nodes' own damping is left to the method. dt, band: see begin_element_forces.
    """
    set_element_forces(nodes, sheet.weights, coefficients, work, dt, band)
    # Springs (eq. 1.2) and weight (eq. 1.1).
    if max(coefficients.springs.k) > 0.0:
        set_springs_and_weight(nodes.position, work.tensions, sheet.mass, coefficients.gravity,
                               work.force, band)
    else:
        set_weight(sheet.mass, coefficients.gravity, work.force, band)
    # Bending.
    if max(coefficients.bend) > 0.0:
        add_bending_forces(work.moments, work.force, band)
    # The wind on the faces, spread over their nodes (eq. 1.4).
    if coefficients.wind.drag > 0.0:
        add_wind_forces(work.faces, work.force, band)
