"""A joint's whole design: claims of the paper, mass, air, and what is refused."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

import layflat.design
from layflat.design import Characteristic, design_joint
from layflat.errors import DesignError, MachineError
from layflat.machine import load

ARM = load("paper-arm")


def test_public_surface_is_complete() -> None:
    for name in layflat.design.__all__:
        assert getattr(layflat.design, name).__doc__


@pytest.mark.parametrize(("name", "torque", "within"), [("large", 84.0, 0.05), ("small", 27.0, 0.08)])
def test_torque_at_4_bar_is_the_papers(name: str, torque: float, within: float) -> None:
    assert design_joint(ARM, name).mean_torque == pytest.approx(torque, rel=within)


def test_torque_is_constant_with_the_cam_and_halves_without() -> None:
    design = design_joint(ARM, "large")
    angle, torque = design.torque
    assert np.ptp(torque) <= 0.01 * torque.mean()
    assert np.degrees(angle[-1]) > 120
    _, uncompensated = design.roller_torque
    assert 0.45 < uncompensated[-1] / uncompensated[0] < 0.56


def test_roller_joints_have_no_cam() -> None:
    design = design_joint("rig-polyester")
    assert design.cam is None
    assert design.outline is None
    np.testing.assert_allclose(design.torque[1], design.roller_torque[1])
    np.testing.assert_allclose(design.tension, design.torque[1] / design.joint.output.radius)
    with pytest.raises(DesignError, match='"roller" has no cam; give "cam"'):
        design.columns()


@pytest.mark.parametrize("name", ["large", "small"])
def test_parts_weigh_less_than_the_joint(name: str) -> None:
    mass = design_joint(ARM, name).mass
    assert all(part > 0 for part in mass.parts.values())
    assert mass.counted + mass.uncounted == pytest.approx(mass.body)
    assert 0.2 < mass.counted / mass.body < 0.4


def test_masses_of_hose_and_cover_by_hand() -> None:
    joint, mass = ARM.joint["large"], design_joint(ARM, "large").mass
    arc = joint.cylinder.diameter / 2 * joint.hose.wrap
    assert mass.parts["hose"] == pytest.approx(2 * 2 * 0.16 * (arc + 0.03) * 0.9)
    assert mass.parts["cover"] == pytest.approx(2 * 0.16 * arc * 0.002 * 2700)
    assert mass.parts["cylinder"] == pytest.approx(2700 * pi / 4 * (0.1524**2 - 0.1464**2) * 0.192, rel=1e-3)


def test_air_fills_the_hose_from_ambient_to_supply() -> None:
    air = design_joint(ARM, "large").air
    isothermal = (5.01325 * (air.swept_volume + air.dead_volume) - 1.01325 * air.dead_volume) * 1e3
    assert air.normal_litres == pytest.approx(isothermal / 1.01325 * 273.15 / 293.15, rel=1e-6)


def test_joint_may_be_left_out_where_there_is_one() -> None:
    assert design_joint("paper-small-joint").name == "small"
    with pytest.raises(MachineError, match="the joint is missing; name one of large, small"):
        design_joint(ARM)
    with pytest.raises(MachineError, match="unknown joint 'elbow'; name one of large, small"):
        design_joint(ARM, "elbow")


def test_missing_files_and_unknown_machines_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=r"none\.toml"):
        design_joint(tmp_path / "none.toml")
    with pytest.raises(MachineError, match="did you mean 'paper-arm'"):
        design_joint("paper-arn")


def test_a_scattered_table_is_warned_of() -> None:
    own = design_joint(ARM, "large").characteristic
    scattered = Characteristic(own.travel, own.force, "bench.csv", fit_error=0.05)
    rules = {f.rule: f for f in design_joint(ARM, "large", measured=scattered).findings}
    assert "up to 5 % from the curve" in rules["measured table"].what
