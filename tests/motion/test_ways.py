"""Paths: they go where they say, with derivatives that are theirs, and are refused where the arm can't go."""

from __future__ import annotations

from math import pi
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from layflat.errors import InputError, MachineError
from layflat.machine import changed, load
from layflat.motion.curve import ArcCurve, Curve, LineCurve, SplineCurve
from layflat.motion.kinematics import planar_links, tip_motion, tip_position
from layflat.motion.path import JointLine, JointPath, JointSpline
from layflat.motion.planar import PlanarPath, PlanarReach
from layflat.physics.arms import ArmPart

ARM, SMALL = load("paper-arm-fast"), load("paper-small-joint-fast")
STRETCHED = changed(ARM, "arm.elbow", 0.0)
START = np.radians([5.0, 10.0])
TIP = tuple(tip_position(ARM, START).tolist())
CURVES: dict[str, Curve] = {
    "line": LineCurve.from_points(TIP, (0.5, 0.2), "line"),
    "arc": ArcCurve.from_points(TIP, (0.48, 0.3), (0.45, 0.2), "arc"),
    "via": SplineCurve([TIP, (0.5, 0.3), (0.45, 0.2), (0.3, 0.4)], "via"),
}
PATHS: dict[str, JointPath] = {
    **{name: PlanarPath(ARM, curve, START, name) for name, curve in CURVES.items()},
    "joint line": JointLine(START, np.radians([-30.0, 40.0])),
    "joint via": JointSpline(ARM, [START, np.radians([20.0, 30.0]), np.radians([20.0, -30.0])]),
    "there and back": JointSpline(SMALL, [np.array([0.7]), np.array([0.2]), np.array([0.4])]),
}


@pytest.mark.parametrize("name", PATHS)
def test_derivatives_are_those_of_the_angles(name: str) -> None:
    """Against central differences of an eighth order, away from the ends."""
    path, h = PATHS[name], 1e-3 * PATHS[name].length
    s = np.linspace(5 * h, path.length - 5 * h, 41)
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / h
    around = [path.evaluate(s + k * h) for k in range(-4, 5)]
    _, first, second = path.evaluate(s)
    # The third derivative of a spline jumps at its points, where differences are off.
    size = float(np.abs(second).max()) + 1.0
    assert_allclose(sum(w * a.value for w, a in zip(weights, around, strict=True)), first, atol=2e-4 * size)
    assert_allclose(sum(w * a.first for w, a in zip(weights, around, strict=True)), second, atol=2e-2 * size)
    if "via" not in name and name != "there and back":
        assert_allclose(sum(w * a.value for w, a in zip(weights, around, strict=True)), first, atol=1e-9 * size)
        assert_allclose(sum(w * a.first for w, a in zip(weights, around, strict=True)), second, atol=1e-8 * size)


@pytest.mark.parametrize("name", CURVES)
def test_the_tip_is_on_its_curve_and_moves_along_it(name: str) -> None:
    path, curve = PATHS[name], CURVES[name]
    s = np.linspace(0.0, curve.length, 101)
    angles, (x, first, second) = path.evaluate(s), curve.evaluate(s)
    assert_allclose(tip_position(ARM, angles.value), x, atol=1e-12)
    velocity, acceleration = tip_motion(ARM, *angles)
    assert_allclose(velocity, first, atol=1e-11)
    assert_allclose(acceleration, second, atol=1e-9)
    assert_allclose(angles.value[0], START, atol=1e-12)
    assert_allclose(path.end, angles.value[-1])


@given(st.floats(0.1, 1.0), st.floats(-pi, pi), st.floats(0.1, 6.1), st.floats(0.1, 0.9), st.booleans())
def test_an_arc_goes_through_its_points(radius: float, begin: float, sweep: float, share: float, back: bool) -> None:
    sign = -1.0 if back else 1.0
    angles = begin + sign * sweep * np.array([0.0, share, 1.0])
    start, middle, end = (0.3 + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)).tolist()
    arc = ArcCurve.from_points(start, middle, end, "arc")
    assert arc.radius == pytest.approx(radius, rel=1e-4)
    assert arc.length == pytest.approx(radius * sweep, rel=1e-4)
    assert_allclose(arc.evaluate(arc.length * np.array([0.0, share, 1.0])).value, [start, middle, end], atol=1e-4)
    assert np.linalg.norm(arc.evaluate(np.array([0.3 * arc.length])).first) == pytest.approx(1.0)


def test_splines_pass_through_their_points() -> None:
    for curve, points in ((CURVES["via"], [TIP, (0.5, 0.3), (0.45, 0.2), (0.3, 0.4)]),):
        s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        assert_allclose(curve.evaluate(s).value, points, atol=1e-12)


@given(st.floats(-58, 58), st.floats(-58, 58), st.floats(-pi, pi))
def test_the_border_is_where_the_reach_ends(first: float, second: float, direction: float) -> None:
    """Of an arm that has but one elbow, by the closed arcs of `Reach`."""
    start, reach = np.radians([first, second]), PlanarReach(ARM, margin=0.0)
    x, y = tip_position(ARM, start).tolist()
    path = PlanarPath(ARM, LineCurve((x, y), (np.cos(direction), np.sin(direction)), 2.0), start, "line")
    border = path.reach_limit(2.0)
    assert border is not None  # an arm of 0.8 m can't go 2 m
    for inside in path.curve.evaluate(np.linspace(0.0, border - 1e-6, 9).clip(0.0)).value.tolist():
        assert reach.distance_outside(*inside) < 1e-6
    assert reach.distance_outside(*path.curve.evaluate(np.array([border + 1e-6])).value[0].tolist()) > 0.0


@pytest.mark.parametrize(
    ("machine", "start", "end", "expected"),
    [
        (ARM, (0, 0), (1.0, 1.0), r"reach 0.\d+ m along its 0.8\d+ m, at x = \d+ mm, .* where joint 'small' leaves"),
        (ARM, (0, 0), (-0.1, -0.1), r"where joint 'small' leaves its stroke of \+-60 deg; give a path within it"),
        (STRETCHED, (0, 40), (0.9, 0.5), r"where the elbow is stretched or folded; give a path that bends it"),
        (STRETCHED, (-55, 20), (0.1, 0.76), r"only the other elbow gets there|stretched"),
        (STRETCHED, (0, 0), (0.5, 0.5), r"begins with a stretched or folded elbow; move the joints first"),
        (SMALL, (0,), (0.1, 0.1), r"needs two joints, paper-small-joint-fast has one; give angles"),
    ],
)
def test_a_line_that_the_arm_can_not_follow_is_refused(
    machine: object, start: tuple[float, ...], end: tuple[float, float], expected: str
) -> None:
    at = np.radians(start)
    tip = tuple(tip_position(machine, at).tolist())  # type: ignore[arg-type]
    with pytest.raises(InputError, match=f"^here: .*{expected}") as caught:
        PlanarPath(machine, LineCurve.from_points(tip, end, "here"), at, "here").check_reachable()  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_curves_that_make_no_sense_are_refused() -> None:
    with pytest.raises(InputError, match="ends where it begins"):
        LineCurve.from_points(TIP, TIP, "line")
    with pytest.raises(InputError, match="three points on a straight line"):
        ArcCurve.from_points((0.0, 0.0), (0.1, 0.1), (0.3, 0.3), "arc")
    with pytest.raises(InputError, match="same point twice in a row"):
        SplineCurve([TIP, (0.5, 0.3), (0.5, 0.3)], "via")
    with pytest.raises(InputError, match=r"stroke \d+.\d deg along its \d+.\d deg, with joint 'small' at 6\d.\d deg"):
        JointSpline(ARM, [np.radians(q) for q in ((0, 0), (2, 58), (42, 58), (44, 0))])


def test_an_arm_of_another_kind_has_no_motions_of_its_tip() -> None:
    class Mine(ArmPart):
        kind: Literal["mine"] = "mine"

    other = ARM.model_copy(update={"arm": Mine.model_construct(**{})})
    with pytest.raises(MachineError, match="has an arm of kind 'mine'; motions of the tip need one of kind"):
        planar_links(other)
