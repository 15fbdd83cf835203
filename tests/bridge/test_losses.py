from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from layflat.bridge import save_arm, to_mjcf, to_urdf
from layflat.bridge.arm import conversion_losses
from layflat.bridge.robots import import_arm
from layflat.machine import load
from tests.bridge.robot_files import written
from tests.physics.arms.chain.chains import as_chain, random_arm

mujoco: Any = pytest.importorskip("mujoco")

GEARED = """<mujoco model="geared"><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0" range="-35 35"
armature="0.05"/><inertial pos="0 0 0.1" mass="0.5" diaginertia="0.002 0.002 0.001"/></body></worldbody></mujoco>"""


def test_a_urdf_says_that_it_lacks_armature_and_layflat_reads_it_back(tmp_path: Path) -> None:
    machine = import_arm(written(tmp_path, GEARED, "geared.xml")).machine
    (line,) = conversion_losses(machine, ".urdf")
    assert line.startswith("URDF has no armature, so other tools miss it in the mass matrix: shoulder 0.05 kg m2; ")
    assert conversion_losses(machine, ".xml") == []
    for name in ("out.urdf", "out.xml"):
        save_arm(machine, tmp_path / name)
        assert import_arm(tmp_path / name).machine.arm.link["shoulder"].armature == 0.05


def test_a_plain_arm_loses_nothing() -> None:
    assert conversion_losses(as_chain(), ".xml") == conversion_losses(load("paper-arm"), ".xml") == []


def test_a_urdf_says_what_gravity_it_has() -> None:
    (line,) = [line for line in conversion_losses(random_arm(4, 1), ".urdf") if "gravity" in line]
    assert line.startswith("URDF has no gravity: MuJoCo reads ")


def test_springs_are_in_mjcf_and_missed_in_urdf() -> None:
    machine = load("single-joint-lift")
    (name,), (joint,) = machine.joints, machine.joints.values()
    assert joint.spring is not None
    assert f"URDF has no springs of joints: {name}; MJCF (.xml) carries them" in conversion_losses(machine, ".urdf")
    model = mujoco.MjModel.from_xml_string(to_mjcf(machine))
    data = mujoco.MjData(model)
    for angle in (-0.3, 0.0, 0.4):
        data.qpos[:] = angle
        mujoco.mj_forward(model, data)
        wanted = joint.spring.torque - joint.spring.stiffness * angle
        assert joint.spring.stiffness == 0.0 or data.qfrc_spring[0] == pytest.approx(wanted)


def test_a_frame_without_mass_weighs_nothing_for_readers_that_else_take_a_kilogram() -> None:
    (link,) = [link for link in fromstring(to_urdf(load("paper-arm"))).findall("link") if link.get("name") == "tool"]
    mass = link.find("inertial/mass")
    assert mass is not None
    assert float(mass.get("value") or "nan") == 0.0
    model = mujoco.MjModel.from_xml_string(to_urdf(load("paper-arm")))
    assert np.isclose(model.body_mass.sum(), mujoco.MjModel.from_xml_string(to_mjcf(load("paper-arm"))).body_mass.sum())
