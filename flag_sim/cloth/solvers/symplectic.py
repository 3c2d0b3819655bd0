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

"""Symplectic (semi-implicit) Euler: velocity first, then position by the new velocity."""
import math

from flag_sim.cloth.aerodynamics import share
from flag_sim.cloth.bending import unbend
from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import set_parts
from flag_sim.cloth.mesh import ONE
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.springs import pull
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait


@wide_kernel
def _move(position, velocity, tensions, moments, faces, mass, gravity, inverse_mass, position_out,
          velocity_out, dt, keep, span):
    """
    Sum the forces on each node (1.6) and move it; pins and ghosts have no inverse mass and stay.

    One loop, so that no force is written to memory and read again: a tenth of a step. moments,
    faces: of Work, or None where they are not to be summed, for which numba compiles a loop of
    its own. keep: what node damping leaves of a velocity in a step, taken implicitly:
    1 / (1 + dt nu).
    """
    x, y, z = position
    vx, vy, vz = velocity
    across, down, rising, falling = tensions
    if moments is not None:
        (ax, dx, tx), (ay, dy, ty), (az, dz, tz) = moments
    if faces is not None:
        ux, uy, uz, lx, ly, lz = faces
    x_out, y_out, z_out = position_out
    vx_out, vy_out, vz_out = velocity_out
    first, last, stride = span
    for i in range(first, last):
        e, w, s, n = i + ONE, i - ONE, i + stride, i - stride
        se, nw, sw, ne = s + ONE, n - ONE, s - ONE, n + ONE
        te, tw, ts, tn = across[i], across[w], down[i], down[n]
        tse, tnw, tsw, tne = falling[i], falling[nw], rising[w], rising[n]
        fx = pull(x[i], x[e], x[w], x[s], x[n], x[se], x[nw], x[sw], x[ne],
                  te, tw, ts, tn, tse, tnw, tsw, tne)
        fy = pull(y[i], y[e], y[w], y[s], y[n], y[se], y[nw], y[sw], y[ne],
                  te, tw, ts, tn, tse, tnw, tsw, tne)
        fz = pull(z[i], z[e], z[w], z[s], z[n], z[se], z[nw], z[sw], z[ne],
                  te, tw, ts, tn, tse, tnw, tsw, tne) - gravity * mass[i]
        if moments is not None:
            fx += unbend(ax[i], ax[e], ax[w], dx[i], dx[s], dx[n],
                         tx[i], tx[w], tx[n], tx[nw])
            fy += unbend(ay[i], ay[e], ay[w], dy[i], dy[s], dy[n],
                         ty[i], ty[w], ty[n], ty[nw])
            fz += unbend(az[i], az[e], az[w], dz[i], dz[s], dz[n],
                         tz[i], tz[w], tz[n], tz[nw])
        if faces is not None:
            fx += share(ux[i], ux[w], ux[n], lx[w], lx[n], lx[nw])
            fy += share(uy[i], uy[w], uy[n], ly[w], ly[n], ly[nw])
            fz += share(uz[i], uz[w], uz[n], lz[w], lz[n], lz[nw])
        t_m = dt * inverse_mass[i]            # a = t F / m: 1.7, 1.8
        vx_new = (vx[i] + t_m * fx) * keep    # v = v0 + a: 1.9
        vy_new = (vy[i] + t_m * fy) * keep
        vz_new = (vz[i] + t_m * fz) * keep
        vx_out[i], vy_out[i], vz_out[i] = vx_new, vy_new, vz_new
        x_out[i] = x[i] + dt * vx_new         # x = x0 + v: 1.10, with v in metres per second
        y_out[i] = y[i] + dt * vy_new
        z_out[i] = z[i] + dt * vz_new


@shared_kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    one = type(dt)(1.0)
    keep = one / (one + dt * coefficients.node_damping)
    is_bent, is_blown = max(coefficients.bend) > 0.0, coefficients.drag > 0.0
    g = coefficients.gravity
    tensions, moments, faces = work.tensions, work.moments, work.faces
    for _ in range(count):
        set_parts(position, velocity, wind, weights, coefficients, work, dt, span)
        if is_bent and is_blown:
            _move(position, velocity, tensions, moments, faces, mass, g, inverse_mass,
                  position_out, velocity_out, dt, keep, span)
        elif is_bent:
            _move(position, velocity, tensions, moments, None, mass, g, inverse_mass,
                  position_out, velocity_out, dt, keep, span)
        elif is_blown:
            _move(position, velocity, tensions, None, faces, mass, g, inverse_mass,
                  position_out, velocity_out, dt, keep, span)
        else:
            _move(position, velocity, tensions, None, None, mass, g, inverse_mass,
                  position_out, velocity_out, dt, keep, span)
        collide(position, position_out, velocity_out, coefficients.limits, work.contact, span)
        wait(work.barrier)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class Symplectic(Solver):
    """
    The method that the source text steps with (1.7 to 1.11), its units put right.

    First order; conditionally stable: see largest_step. Springs and bending are explicit, the drag
    of the wind and the nodes' own damping implicit. Without damping it keeps the energy within a
    bound for ever, since it is symplectic.
    """

    order = 1

    take_steps = staticmethod(_take_steps)
    is_shared = True

    @classmethod
    def largest_step(cls, omega, gamma, air):
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        A mode obeys v' = v - h (omega^2 x + gamma v), x' = x + h v'. Its amplification matrix has
        determinant 1 - h gamma and trace 2 - h gamma - h^2 omega^2: both its eigenvalues are
        within the unit circle (Jury) where h^2 omega^2 + 2 h gamma <= 4. The drag of the air adds
        its own rate to h gamma, and keeps twice its greatest of these 4.
        """
        room = 4.0 - 2.0 * air.greatest_rate(cls.order)
        rate = gamma + math.sqrt(gamma**2 + room * omega**2)
        return room / rate if rate > 0.0 else math.inf
