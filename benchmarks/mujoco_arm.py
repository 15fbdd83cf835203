"""The paper's arm alone in MuJoCo, with torques at its joints: the yardstick of speed."""

from __future__ import annotations

from typing import Any

import mujoco as _mujoco

from layflat.machine import Machine

mujoco: Any = _mujoco

XML = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0"/>
  <worldbody>
    <body>
      <joint name="large" type="hinge" axis="0 0 1" damping="{d1}" frictionloss="{f1}" armature="{i1}"/>
      <inertial pos="{c1} 0 0" mass="{m1}" diaginertia="1e-4 1e-4 1e-4"/>
      <body pos="{l1} 0 0">
        <joint name="small" type="hinge" axis="0 0 1" damping="{d2}" frictionloss="{f2}" armature="{i2}"/>
        <inertial pos="{c2} 0 0" mass="{m2}" diaginertia="1e-4 1e-4 1e-4"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="large"/><motor joint="small"/></actuator>
</mujoco>
"""


def build(machine: Machine, *, brakes: bool = False) -> tuple[Any, Any]:
    """Model and data of the arm with its payload."""
    large, small = machine.joint["large"], machine.joint["small"]
    payload = machine.arm.payload
    mass_2 = small.link.mass + payload
    model = mujoco.MjModel.from_xml_string(
        XML.format(
            step=0.25e-3,
            d1=large.brake.viscous,
            d2=small.brake.viscous,
            f1=large.brake.torque if brakes else 0.0,
            f2=small.brake.torque if brakes else 0.0,
            i1=large.link.rotor_inertia,
            i2=small.link.rotor_inertia,
            l1=large.link.length,
            m1=large.link.mass + small.body.mass,
            c1=(large.link.mass * large.link.centre + small.body.mass * large.link.length)
            / (large.link.mass + small.body.mass),
            m2=mass_2,
            c2=(small.link.mass * small.link.centre + payload * small.link.length) / mass_2,
        )
    )
    data = mujoco.MjData(model)
    data.ctrl[:] = (10.0, 3.0)
    return model, data


def run(arm: tuple[Any, Any], steps: int) -> None:
    """Advance by some steps, from rest."""
    model, data = arm
    mujoco.mj_resetData(model, data)
    data.ctrl[:] = (0.5, 0.2)
    mujoco.mj_step(model, data, steps)
