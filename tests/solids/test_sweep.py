"""Outputs that would sweep into their frame are refused in one line, with a value that mends it."""

import re
from itertools import pairwise

import numpy as np
import pytest

from layflat.design import JointDesign, SizingRequest, design_joint, size_joint
from layflat.errors import DesignError
from layflat.machine import changed, load
from layflat.machine.build_sizes import Build
from layflat.solids.joint import joint_components
from layflat.solids.mends import buildable_components
from layflat.solids.output import link_holes
from layflat.solids.places import bar_place, stop_places, stop_radius
from layflat.solids.section import CrossSection
from layflat.solids.sizes import MM, JointSizes
from layflat.solids.sweep import check_sweep


def sized(torque: str, stroke: str, supply: str) -> JointDesign:
    return size_joint(SizingRequest(torque=torque, stroke=stroke, supply=supply)).design


def with_key(design: JointDesign, table: str, key: str, value: float | str) -> JointDesign:
    """A design with one key of the joint changed."""
    return design_joint(changed(design.machine, f"joint.{design.name}.{table}.{key}", value), design.name)


def advised(design: JointDesign, match: str, key: str) -> float:
    """The value, m, that the refusal of a joint gives in mm after a key."""
    with pytest.raises(DesignError, match=match) as error:
        buildable_components(JointSizes(design))
    return 1e-3 * float(re.search(key + r" of (\d+) mm", str(error.value))[1])  # type: ignore[index]


def test_a_cam_that_meets_the_cylinder_is_refused_and_the_advice_mends_it() -> None:
    design = sized("50 N m", "89 deg", "4.2 bar")
    offset = advised(design, r"the cam sweeps .* give output\.shaft_offset", "shaft_offset")
    check_sweep(JointSizes(with_key(design, "output", "shaft_offset", offset)))


def test_holes_for_a_link_lie_beyond_straps_that_cross_the_arm() -> None:
    """The cam of a short stroke is long: its strap passes where the link would be screwed on."""
    long = JointSizes(with_key(sized("25.35 N m", "60.17 deg", "5.64 bar"), "output", "shaft_offset", 0.022))
    section, holes = CrossSection(long), np.array([[0.0, at] for at in link_holes(long)])
    for angle in np.linspace(-long.swing, long.swing, 41):
        c, s = np.cos(angle), np.sin(angle)
        points = holes @ np.array([[c, s], [-s, c]]) + [0.0, long.axis]
        path = section.strap_path(long.stroke / 2 + float(angle))
        fine = np.vstack([np.linspace(a, b, 50) for a, b in pairwise(path)])
        nearest = np.hypot(*(fine[:, None] - points).T).min(axis=1)
        assert (nearest > np.array([1.0, 1.1, 1.0]) * long.screw.nut_flats * MM / 2).all()


def test_a_retaining_ring_that_meets_the_cylinder_is_refused_and_the_advice_mends_it() -> None:
    design = with_key(sized("88.5 N m", "128 deg", "3.5 bar"), "output", "shaft_offset", 0.064)
    offset = advised(design, r"retaining ring .* meets the cylinder; give output\.shaft_offset", "shaft_offset")
    joint_components(JointSizes(with_key(design, "output", "shaft_offset", offset)))


@pytest.mark.parametrize("offset", [0.018, 0.022, 0.026])
def test_bump_stops_lie_beside_the_cylinder_and_meet_the_arm_at_the_mechanical_limit(offset: float) -> None:
    sizes = JointSizes(with_key(sized("25.35 N m", "60.17 deg", "5.64 bar"), "output", "shaft_offset", offset))
    (_, stop), radius = stop_places(sizes), stop_radius(sizes)
    away = float(np.hypot(*stop))
    assert away + radius < sizes.inner_radius or away - radius > sizes.radius
    along = np.array([np.sin(sizes.swing), np.cos(sizes.swing)])
    x, y = np.array(stop) - [0.0, sizes.axis]
    assert abs(x * along[1] - y * along[0]) == pytest.approx(sizes.arm_width / 2 + radius)


def test_cylinders_too_small_for_a_clamp_are_refused_in_one_line_and_the_advice_mends_it() -> None:
    design = sized("1.9 N m", "116 deg", "5.9 bar")
    diameter = advised(design, r"hoses' clamp have no place .*; give cylinder\.diameter of 4\d mm", "diameter")
    bar_place(JointSizes(with_key(design, "cylinder", "diameter", diameter)))
    with pytest.raises(DesignError):
        bar_place(JointSizes(with_key(design, "cylinder", "diameter", diameter - 1e-3)))


@pytest.mark.parametrize("thickness", [0.002, 0.011, 0.017, 0.04, 0.1])
def test_clamp_bars_that_no_screws_fit_are_refused_with_those_that_do(thickness: float) -> None:
    design = design_joint(load("paper-small-joint"), "small")
    with pytest.raises(DesignError, match="screws of the hoses' clamp have no place") as error:
        bar_place(JointSizes(with_key(design, "build", "clamp_bar_thickness", thickness)))
    least, most = map(float, re.findall(r"([\d.]+) mm", str(error.value))[-2:])
    for bar in (least, most):
        joint_components(JointSizes(with_key(design, "build", "clamp_bar_thickness", 1e-3 * bar)))


def test_small_cylinders_have_small_screws() -> None:
    small, large = (JointSizes(sized(torque, "70 deg", "3.8 bar")) for torque in ("2.5 N m", "5 N m"))
    assert (small.screw.name, small.rod.name, large.screw.name) == ("M2.5", "M2.5", "M3")
    assert any("M2.5" in part.designation for part in joint_components(small))


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
