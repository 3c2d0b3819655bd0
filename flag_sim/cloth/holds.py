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
Position constraints: long range attachments to the hoist, and collision with the pole.

What no node may do, whatever the forces: get farther from the hoist than the cloth reaches, or
enter the pole. A node that does is projected back, and loses the velocity that took it there.
"""
import math

from flag_sim.kernels import kernel
import numpy as np


def hold(state, stretch_limit, pole):
    """
    Bring back what is in the pole or too far from a held hoist; return how many were too far.

    No node stays farther from the beginning of its row than 1 + stretch_limit times its distance
    at rest. pole: x, y and radius [m], measured as the state's positions; radius zero for none.
    """
    mesh, position, velocity = state.mesh, state.position, state.velocity
    pole = mesh.number(pole)
    hoist = tuple(mesh.grid(axis)[:, 0].copy() for axis in position)
    reach = mesh.number((1.0 + stretch_limit) * mesh.dx)
    limits = hoist, reach, mesh.free, mesh.columns
    held = hold_reach(position, velocity, *limits, mesh.span)
    if pole[2] > 0.0:
        hold_outside(position, velocity, mesh.free, pole, mesh.span)
        # Brings back within reach what was put on the pole's surface, and leaves it there.
        hold_around(position, velocity, *limits, pole, mesh.span)
    return held


@kernel
def hold_reach(position, velocity, hoist, reach, free, columns, span):
    """
    Bring back every node that is farther from the hoist than the cloth reaches; return how many.

    A long range attachment (Kim, Chentanez, Mueller-Fischer, Long Range Attachments, 2012): a node
    in column c stays within c reach [m] of the node hoist[axis][row] that begins its row, and a
    velocity outwards is taken from it.
    """
    x, y, z = position
    vx, vy, vz = velocity
    hx, hy, hz = hoist
    first, last, stride = span
    number = type(reach)
    held = 0
    for row in range(hx.size):
        for column in range(1, columns):
            i = first + np.uint64(row) * stride + np.uint64(column)
            dx, dy, dz = x[i] - hx[row], y[i] - hy[row], z[i] - hz[row]
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            longest = reach * number(column)
            if distance > longest and free[i] > 0.0:
                held += 1
                dx, dy, dz = dx / distance, dy / distance, dz / distance
                x[i] = hx[row] + longest * dx
                y[i] = hy[row] + longest * dy
                z[i] = hz[row] + longest * dz
                out = max(vx[i] * dx + vy[i] * dy + vz[i] * dz, number(0.0))
                vx[i] -= out * dx
                vy[i] -= out * dy
                vz[i] -= out * dz
    return held


@kernel
def hold_outside(position, velocity, free, pole, span):
    """
    Put every node inside the pole on its surface, and stop it moving inwards.

    pole: x, y and radius [m] of an upright cylinder; with radius zero nothing is inside. Solvers
    call this after each step, lest a frame carries the cloth through.
    """
    center_x, center_y, radius = pole
    if not radius > 0.0:
        return
    x, y, _ = position
    vx, vy, _ = velocity
    number = type(radius)
    first, last, _ = span
    for i in range(first, last):
        dx, dy = x[i] - center_x, y[i] - center_y
        distance2 = dx * dx + dy * dy
        if distance2 < radius * radius and free[i] > 0.0:
            distance = math.sqrt(distance2)
            if distance > 0.0:
                dx, dy = dx / distance, dy / distance
            else:
                dx, dy = number(1.0), number(0.0)
            x[i] = center_x + radius * dx
            y[i] = center_y + radius * dy
            inwards = min(vx[i] * dx + vy[i] * dy, number(0.0))
            vx[i] -= inwards * dx
            vy[i] -= inwards * dy


@kernel
def hold_around(position, velocity, hoist, reach, free, columns, pole, span):
    """
    Bring back what is outside a cylinder and beyond its reach, around the cylinder.

    In cylindrical coordinates a straight path leads from a node to its hoist: it never enters a
    cylinder that both are outside of. No chord is longer than the path that it cuts short, so a
    node that is put where a path of length L has reach left is within it.
    """
    x, y, z = position
    vx, vy, vz = velocity
    hx, hy, hz = hoist
    center_x, center_y, radius = pole
    first, last, stride = span
    number = type(reach)
    for row in range(hx.size):
        ox, oy = hx[row] - center_x, hy[row] - center_y
        begin = math.sqrt(ox * ox + oy * oy)
        for column in range(1, columns):
            i = first + np.uint64(row) * stride + np.uint64(column)
            dx, dy, dz = x[i] - hx[row], y[i] - hy[row], z[i] - hz[row]
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            longest = reach * number(column)
            if distance > longest and free[i] > 0.0:
                nx, ny = x[i] - center_x, y[i] - center_y
                end = math.sqrt(nx * nx + ny * ny)
                turn = math.atan2(ox * ny - oy * nx, ox * nx + oy * ny)
                around = max(begin, end, radius) * turn
                part = longest / math.sqrt((end - begin)**2 + around * around + dz * dz)
                out = begin + part * (end - begin)
                angle = math.atan2(oy, ox) + part * turn
                x[i] = center_x + out * math.cos(angle)
                y[i] = center_y + out * math.sin(angle)
                z[i] = hz[row] + part * dz
                dx, dy, dz = dx / distance, dy / distance, dz / distance
                outwards = max(vx[i] * dx + vy[i] * dy + vz[i] * dz, number(0.0))
                vx[i] -= outwards * dx
                vy[i] -= outwards * dy
                vz[i] -= outwards * dz
