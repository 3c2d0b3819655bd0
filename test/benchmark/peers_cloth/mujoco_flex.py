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
MuJoCo's flex: a membrane of triangles (Saint Venant and Kirchhoff), one body a node.

MuJoCo's air does not act on a flex, so numpy computes the wind from outside. Every step would
cost MuJoCo a third of its speed; the wind is computed once for WIND_STEPS and held in between.
"""
import mujoco
import numpy as np

from peers_cloth.case import Sheet
from peers_cloth.numpy_slices import add_wind

WIND_STEPS = 10
THICKNESS = 1e-3  # [m]: MuJoCo's plates are solid ones, of a Young's modulus and a thickness

MODEL = """
    <mujoco>
      <option timestep="{dt}" integrator="Euler" gravity="0 0 -{gravity}">
        <flag contact="disable" constraint="disable"/>
      </option>
      <worldbody>
        <flexcomp name="cloth" type="direct" dim="2" mass="{mass}" radius="{thickness}"
                  point="{points}" element="{triangles}">
          <contact contype="0" conaffinity="0" selfcollide="none"/>
          <elasticity young="{young}" poisson="{poisson}" thickness="{thickness}"
                      damping="{damping}" elastic2d="{elastic}"/>
          <pin id="{pins}"/>
        </flexcomp>
      </worldbody>
    </mujoco>"""


def words(array):
    """Return numbers as MJCF wants them."""
    return ' '.join(map(repr, np.asarray(array).ravel().tolist()))


class Peer:
    """Explicit steps (integrator Euler), contacts and constraints off."""

    precision = 'float64'

    def __init__(self, case):
        sheet = self._sheet = Sheet(case)
        self._dt = case.dt
        self._wind = np.array(case.wind)[:, None, None]
        c11, c12 = sheet.stiffness + sheet.shear_stiffness, sheet.shear_stiffness
        index = np.arange(case.nodes).reshape(case.rows, case.columns)
        _, k, c, _ = sheet.springs[0]
        model = self._model = mujoco.MjModel.from_xml_string(MODEL.format(
            dt=case.dt, gravity=sheet.gravity, mass=sheet.mass.sum(), thickness=THICKNESS,
            points=words(sheet.positions), triangles=words(sheet.triangles()),
            young=(c11 - c12**2 / c11) / THICKNESS, poisson=c12 / c11, damping=c / k,
            elastic='both' if case.has_bending else 'stretch', pins=words(index[:, 0])))
        model.body_mass[model.flex_vertbodyid[index[:, 1:]]] = sheet.mass[:, 1:]
        self._data = mujoco.MjData(model)
        mujoco.mj_setConst(model, self._data)
        self._rest = np.moveaxis(sheet.positions, -1, 0)
        self._x, self._v = self._rest.copy(), np.zeros_like(self._rest)

    def run(self, steps):
        for _ in range(steps // WIND_STEPS):
            self._read()
            force = np.zeros_like(self._x)
            add_wind(force, self._x, self._v, self._wind, self._sheet.drag, self._sheet.hold)
            self._data.qfrc_applied[:] = np.moveaxis(force[:, :, 1:], 0, -1).ravel()
            mujoco.mj_step(self._model, self._data, WIND_STEPS)

    def _read(self):
        """Copy the state of all nodes but the pins, which are no bodies."""
        rows, columns = self._sheet.mass.shape
        shape = (rows, columns - 1, 3)
        self._x[:, :, 1:] = (self._rest[:, :, 1:]
                             + np.moveaxis(self._data.qpos.reshape(shape), -1, 0))
        self._v[:, :, 1:] = np.moveaxis(self._data.qvel.reshape(shape), -1, 0)

    def state(self):
        self._read()
        return np.moveaxis(self._x, 0, -1), np.moveaxis(self._v, 0, -1)
