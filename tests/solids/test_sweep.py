"""Outputs that would sweep into their frame are refused in one line, with a value that mends it."""

import re

import pytest

from layflat.design import JointDesign, SizingRequest, design_joint, size_joint
from layflat.errors import DesignError
from layflat.machine.build_sizes import Build
from layflat.solids.joint import joint_components
from layflat.solids.sizes import JointSizes
from layflat.solids.sweep import check_sweep


def sized(torque: str, stroke: str, supply: str) -> JointDesign:
    return size_joint(SizingRequest(torque=torque, stroke=stroke, supply=supply)).design


def with_key(design: JointDesign, table: str, key: str, value: float) -> JointDesign:
    """A design with one key of the joint changed."""
    joint = design.joint
    part = getattr(joint, table)
    changed = joint.model_copy(update={table: part.model_copy(update={key: value})})
    machine = design.machine
    return design_joint(machine.model_copy(update={"joint": {**machine.joint, design.name: changed}}), design.name)


def test_a_cam_that_meets_the_cylinder_is_refused_and_the_advice_mends_it() -> None:
    design = sized("50 N m", "89 deg", "4.2 bar")
    with pytest.raises(DesignError, match=r"the cam sweeps .* give output\.shaft_offset") as error:
        joint_components(JointSizes(design))
    offset = float(re.search(r"shaft_offset of (\d+) mm", str(error.value))[1])  # type: ignore[index]
    check_sweep(JointSizes(with_key(design, "output", "shaft_offset", 1e-3 * offset)))


def test_cylinders_too_small_for_a_clamp_are_refused_in_one_line() -> None:
    with pytest.raises(DesignError, match=r"no wall around its screws .*; give cylinder\.diameter of 4\d mm or more"):
        joint_components(JointSizes(sized("2.2 N m", "113 deg", "4.2 bar")))


def test_small_cylinders_have_small_inlets() -> None:
    found = joint_components(JointSizes(sized("7.3 N m", "115 deg", "3.2 bar")))
    assert any("inlet" in part.name for part in found)


def test_a_disc_that_is_too_large_is_refused_and_the_advice_mends_it() -> None:
    design = design_joint("paper-small-joint")
    wide = JointSizes(with_build(design, Build(disc_diameter="160 mm")))
    with pytest.raises(DesignError, match=r"outside the end plate; give build\.disc_diameter of") as error:
        joint_components(wide)
    diameter = re.search(r"disc_diameter of ([\d.]+) mm", str(error.value))[1]  # type: ignore[index]
    joint_components(JointSizes(with_build(design, Build(disc_diameter=f"{diameter} mm"))))


def with_build(design: JointDesign, build: Build) -> JointDesign:
    """A design of the same joint built otherwise."""
    machine, joint = design.machine, design.joint.model_copy(update={"build": build})
    return design_joint(machine.model_copy(update={"joint": {**machine.joint, design.name: joint}}), design.name)
