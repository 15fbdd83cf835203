"""The cam: rolled numerically it gives constant torque; its profile is the envelope of the strap's lines."""

from __future__ import annotations

from math import degrees, radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from layflat.design import (
    Cam,
    Characteristic,
    RollerLine,
    ShellLine,
    cam_outline,
    cylinder_characteristic,
    design_joint,
    straplines,
    synthesise,
    write_drawings,
)
from layflat.errors import DesignError
from layflat.machine import Joint, load
from layflat.machine.parameters import full_travel, torque_constant
from layflat.machine.parts import DeflectingRoller
from tests.design.rolled_cam import RolledCam, Shell

ARM = load("paper-arm")
NAMES = ["large", "small"]


def cam_of(joint: Joint) -> Cam:
    return synthesise(cylinder_characteristic(joint), straplines.joint_strap_line(joint), full_travel(joint))


def support(points: np.ndarray[tuple[int, int], np.dtype[np.float64]], angle: float) -> float:
    return float((points @ np.array([np.cos(angle), np.sin(angle)])).max())


@pytest.mark.parametrize("name", NAMES)
def test_rolled_polygon_gives_constant_torque_by_virtual_work(name: str) -> None:
    outline = design_joint(ARM, name).outline
    assert outline is not None
    shell = Shell(ARM.joint[name])
    rolled = RolledCam(outline.profile, shell)
    angles = np.radians(np.linspace(5.0, 128.0, 25))
    torques = np.array([rolled.torque_by_work(float(angle)) for angle in angles])
    np.testing.assert_allclose(torques, torque_constant(ARM.joint[name]), rtol=5e-5)


@pytest.mark.parametrize("name", NAMES)
def test_rolled_polygon_gives_constant_torque_by_its_lever_arm(name: str) -> None:
    outline = design_joint(ARM, name).outline
    assert outline is not None
    rolled = RolledCam(outline.profile, Shell(ARM.joint[name]))
    for angle in np.radians(np.linspace(3.0, 130.0, 25)):
        assert rolled.torque_by_lever(float(angle)) == pytest.approx(torque_constant(ARM.joint[name]), rel=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_profile_touches_every_line_that_virtual_work_asks_for(name: str) -> None:
    joint = ARM.joint[name]
    cam, shell = cam_of(joint), Shell(joint)
    for s in np.linspace(0.0, shell.full_travel, 17):
        lever, normal = shell.line(float(s))
        angle = float(np.interp(s, cam.travel, cam.angle))
        assert support(cam.profile, normal - angle) == pytest.approx(lever, abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_torque_and_stroke_are_those_of_the_dynamics(name: str) -> None:
    joint = ARM.joint[name]
    cam = cam_of(joint)
    assert cam.torque_constant == pytest.approx(torque_constant(joint), rel=1e-12)
    assert cam.stroke == pytest.approx(full_travel(joint), rel=1e-12)


def test_strap_neither_stretches_nor_slips() -> None:
    cam = cam_of(ARM.joint["large"])
    arc = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(cam.profile, axis=0).T))))
    c, s = np.cos(cam.angle), np.sin(cam.angle)
    touch = np.stack((c * cam.profile[:, 0] - s * cam.profile[:, 1], s * cam.profile[:, 0] + c * cam.profile[:, 1]), -1)
    free = np.hypot(*(cam.strap_point - np.array(cam.axis) - touch).T)
    # What comes free of the cam is what the strap gets longer.
    np.testing.assert_allclose(free - free[0], arc, atol=1e-6)


def test_crude_table_and_drum_cam_agree() -> None:
    # Table 1 takes the strap's tension for the force along the travel, as the round drum does.
    joint = with_roller(ARM.joint["large"], 0.015)
    cam = cam_of(joint)
    assert cam.lever[0] == pytest.approx(0.019451, rel=2e-3)
    assert cam.lever[-1] == pytest.approx(0.038306, rel=2e-3)
    assert degrees(cam.stroke) == pytest.approx(133.0525, rel=2e-3)


def with_roller(joint: Joint, diameter: float) -> Joint:
    roller = DeflectingRoller.model_validate(
        {"diameter": f"{diameter} m", "count": 1, "friction_fraction": 0.0, "bending_fraction": 0.0}
    )
    return joint.model_copy(
        update={"deflecting_roller": roller, "output": joint.output.model_copy(update={"shaft_offset": 0.0})}
    )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("diameter", [0.006, 0.015])
def test_on_the_drum_the_line_touches_roller_and_lever_circle(name: str, diameter: float) -> None:
    joint = with_roller(ARM.joint[name], diameter)
    line = straplines.joint_strap_line(joint)
    assert isinstance(line, RollerLine)
    cam = cam_of(joint)
    assert cam.convex
    normals = np.stack((np.cos(cam.line_normal), np.sin(cam.line_normal)), axis=-1)
    np.testing.assert_allclose(normals @ np.array(line.centre) + diameter / 2, cam.lever, atol=1e-12)
    curve = cylinder_characteristic(joint)
    np.testing.assert_allclose(np.gradient(cam.angle, cam.travel)[1:-1], (1 / cam.lever)[1:-1], rtol=1e-4)
    np.testing.assert_allclose(cam.tension, curve.force, rtol=1e-12)


@settings(deadline=None, max_examples=40)
@given(
    width=st.floats(0.05, 0.3),
    share=st.floats(0.8, 1.1),
    wrap=st.floats(radians(80), radians(125)),
    offset=st.floats(0.2, 0.9),
    stroke=st.floats(radians(90), radians(170)),
)
def test_any_cam_that_is_made_touches_its_lines_and_conserves_work(
    width: float, share: float, wrap: float, offset: float, stroke: float
) -> None:
    base = ARM.joint["large"]
    R = share * width / 2
    joint = base.model_copy(
        update={
            "hose": base.hose.model_copy(update={"width": width, "wrap": wrap, "contact_end": 0.7 * wrap}),
            "cylinder": base.cylinder.model_copy(update={"diameter": 2 * R}),
            "output": base.output.model_copy(update={"shaft_offset": offset * R}),
        }
    )
    curve = cylinder_characteristic(joint)
    try:
        cam = synthesise(curve, straplines.joint_strap_line(joint), stroke)
    except DesignError:
        assume(False)
    assume(cam.convex and cam.normal[0] - cam.normal[-1] < radians(170))
    assert cam.torque_constant * cam.stroke == pytest.approx(curve.swept_volume, rel=1e-12)
    np.testing.assert_allclose(cam.tension * cam.alignment, curve.force, rtol=1e-9)
    for k in range(0, 201, 25):
        assert support(cam.profile, float(cam.normal[k])) == pytest.approx(cam.lever[k], abs=1e-9)


@pytest.mark.parametrize("stroke", [0.0, -1.0, float("nan"), float("inf")])
def test_a_stroke_must_be_positive(stroke: float) -> None:
    joint = ARM.joint["large"]
    with pytest.raises(DesignError, match="give a positive stroke"):
        synthesise(cylinder_characteristic(joint), straplines.joint_strap_line(joint), stroke)


def test_a_stroke_too_short_for_any_lever_arm_is_refused() -> None:
    joint = ARM.joint["large"]
    with pytest.raises(DesignError, match="cam:") as caught:
        synthesise(cylinder_characteristic(joint), straplines.joint_strap_line(joint), radians(15))
    assert "\n" not in str(caught.value)


def test_a_shell_that_moves_towards_the_shaft_is_refused() -> None:
    joint = ARM.joint["large"]
    line = straplines.joint_strap_line(joint)
    assert isinstance(line, ShellLine)
    beyond = ShellLine((-0.3, 0.0), line.hinge, line.start)
    with pytest.raises(DesignError, match="does not move away from the output axis"):
        synthesise(cylinder_characteristic(joint), beyond, full_travel(joint))


def test_on_the_drum_a_lever_arm_beyond_the_roller_is_refused() -> None:
    joint = with_roller(ARM.joint["large"], 0.015)
    with pytest.raises(DesignError, match=r"deflecting roller is only 68\.7 mm from the output axis"):
        synthesise(cylinder_characteristic(joint), straplines.joint_strap_line(joint), radians(40))


def wavy() -> Characteristic:
    s = np.linspace(0.0, 0.06, 301)
    return Characteristic(s, 0.01 * (1 - 0.5 * s / 0.06 + 0.01 * np.sin(s / 0.06 * 40)), "a wavy table")


def test_a_wavy_force_makes_a_hollow_cam_that_is_refused() -> None:
    cam = synthesise(wavy(), straplines.joint_strap_line(ARM.joint["large"]), radians(133))
    assert not cam.convex
    with pytest.raises(DesignError, match="not convex: radius of curvature falls to -"):
        cam_outline(cam)
    with pytest.raises(DesignError, match=r"joint\.large\.output: the cam is hollow at .* so a strap can't lie on it"):
        design_joint(ARM, "large", measured=wavy())


def test_a_hollow_cam_can_be_looked_at_but_not_drawn(tmp_path: Path) -> None:
    design = design_joint(ARM, "large", measured=wavy(), strict=False)
    assert design.findings[0].rule == "convexity"
    assert design.cam is not None
    with pytest.raises(DesignError, match="the cam can't be made"):
        write_drawings(design, tmp_path / "out")
    assert not (tmp_path / "out").exists()
