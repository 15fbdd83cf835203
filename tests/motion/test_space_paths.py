"""Paths of the tip in space: on their curves, with derivatives that are theirs, and refused where the arm can't go."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.motion.belt import follow_belt
from layflat.motion.curve import ArcCurve, Curve, LineCurve, SplineCurve, TiltedCurve, arc_through
from layflat.motion.inverse import InverseKinematics
from layflat.motion.jerk_limited import plan_jerk_limited
from layflat.motion.kinematics import Kinematics, tip_motion, tip_position
from layflat.motion.limits import TipLimits, joint_capabilities
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import half_strokes
from layflat.motion.planar import PlanarPath
from layflat.motion.tip_path import SpacePath, tip_path
from tests.physics.arms.chain.chains import as_chain, random_arm

PICKING, PLANAR, CHAINED, SEVEN = load("picking-arm"), load("paper-arm-fast"), as_chain(), random_arm(7, 2)
START = np.radians([20.0, 20.0, -20.0, 20.0])
TIP = tuple(tip_position(PICKING, START).tolist())


def beside(*way: float) -> tuple[float, ...]:
    """A point so far (m) from where the picking arm's tip begins."""
    return tuple(np.add(TIP, way).tolist())


CURVES: dict[str, Curve] = {
    "line": LineCurve.from_points(TIP, beside(-0.1, -0.3, 0.1), "line"),
    "arc": arc_through(TIP, beside(0.0, -0.2, 0.1), beside(0.0, -0.3, -0.1), "arc"),
    "via": SplineCurve([TIP, beside(0.0, -0.2, 0.1), beside(-0.2, -0.3, -0.1)], "via"),
}
WAYS: dict[str, tuple[Machine, SpacePath]] = {
    name: (PICKING, SpacePath(PICKING, curve, START, name)) for name, curve in CURVES.items()
}
at = np.radians([10.0, -20.0, 30.0, 0.0, 20.0, -10.0, 5.0])
seven = tuple(tip_position(SEVEN, at).tolist())
WAYS["seven joints"] = (
    SEVEN,
    SpacePath(SEVEN, LineCurve.from_points(seven, (seven[0] + 0.1, seven[1], seven[2] - 0.1), "l"), at, "l"),
)


@pytest.mark.parametrize("name", WAYS)
def test_the_tip_is_on_its_curve_and_moves_along_it(name: str) -> None:
    machine, path = WAYS[name]
    s = np.linspace(0.0, path.length, 101)
    angles, (x, first, second) = path.evaluate(s), path.curve.evaluate(s)
    assert_allclose(tip_position(machine, angles.value), x, atol=1e-12)
    velocity, acceleration = tip_motion(machine, *angles)
    assert_allclose(velocity, first, atol=1e-11)
    assert_allclose(acceleration, second, atol=1e-9)
    assert path.reach_limit(path.length) is None
    assert path.check_reachable() is path
    assert np.all(np.abs(angles.value) <= half_strokes(machine))


@pytest.mark.parametrize("name", WAYS)
def test_derivatives_are_those_of_the_angles(name: str) -> None:
    """Against central differences of an eighth order, away from the ends."""
    _, path = WAYS[name]
    h = 1e-3 * path.length
    s = np.linspace(5 * h, path.length - 5 * h, 41)
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / h
    around = [path.evaluate(s + k * h) for k in range(-4, 5)]
    _, first, second = path.evaluate(s)
    size = float(np.abs(second).max()) + 1.0
    # The third derivative of a spline jumps at its points, where differences are off.
    exact = (2e-4, 2e-2) if name == "via" else (1e-9, 1e-8)
    assert_allclose(sum(w * a.value for w, a in zip(weights, around, strict=True)), first, atol=exact[0] * size)
    assert_allclose(sum(w * a.first for w, a in zip(weights, around, strict=True)), second, atol=exact[1] * size)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_in_the_plane_it_is_the_closed_form(sign: float) -> None:
    start = np.radians([5.0, 10.0])
    x, y = tip_position(PLANAR, start).tolist()
    flat = PlanarPath(PLANAR, LineCurve((x, y), (-0.8, sign * 0.6), 0.2), start, "flat")
    space = tip_path(CHAINED, LineCurve((x, y, 0.0), (-0.8, sign * 0.6, 0.0), 0.2), start, "space", span=(-0.05, 0.2))
    for of, expected in zip(
        space.evaluate(np.linspace(-0.05, 0.2, 51)), flat.evaluate(np.linspace(-0.05, 0.2, 51)), strict=True
    ):
        assert_allclose(of, expected, atol=1e-9)
    far = SpacePath(CHAINED, LineCurve((x, y, 0.0), (-0.8, sign * 0.6, 0.0), 2.0), start, "space")
    border = PlanarPath(PLANAR, LineCurve((x, y), (-0.8, sign * 0.6), 2.0), start, "flat").reach_limit(2.0)
    assert far.reach_limit(2.0) == pytest.approx(border, abs=1e-6)


def test_an_arm_with_joints_to_spare_keeps_them_from_their_ends() -> None:
    """A wrist that begins near its end comes away from it, and nothing jumps there."""
    start = np.array([0.0, 0.3, -0.3, 0.98 * half_strokes(PICKING)[3]])
    x, y, z = tip_position(PICKING, start).tolist()
    path = SpacePath(PICKING, LineCurve.from_points((x, y, z), (x, y - 0.35, z), "line"), start, "line")
    angles, rates, bends = path.evaluate(np.linspace(0.0, path.length, 200))
    assert abs(angles[-1, 3]) < 0.7 * half_strokes(PICKING)[3]
    assert np.abs(rates).max() < 10.0
    assert np.abs(bends).max() < 200.0


def test_arcs_in_space_go_through_their_points() -> None:
    draw = np.random.default_rng(3)
    for start, middle, end in draw.normal(size=(20, 3, 3)):
        curve = arc_through(tuple(start), tuple(middle), tuple(end), "arc")
        assert isinstance(curve, TiltedCurve)
        x, first, second = curve.evaluate(np.linspace(0.0, curve.length, 2001))
        assert_allclose(x[[0, -1]], [start, end], atol=1e-9)
        assert np.linalg.norm(x - middle, axis=1).min() < 1e-3 * curve.length
        assert_allclose(np.linalg.norm(first, axis=1), 1.0, atol=1e-12)
        assert_allclose(np.sum(first * second, axis=1), 0.0, atol=1e-9 * np.abs(second).max())
    assert isinstance(arc_through((0.0, 0.0), (1.0, 1.0), (2.0, 0.0), "arc"), ArcCurve)
    with pytest.raises(InputError, match="three points on a straight line"):
        arc_through((0.0, 0.0, 0.0), (0.1, 0.1, 0.1), (0.3, 0.3, 0.3), "arc")


@pytest.mark.parametrize(
    ("machine", "start", "way", "expected"),
    [
        (
            PICKING,
            START,
            (0.5, 0.0, 0.0),
            r"reach 0.\d+ m along its 0.500 m, at x = \d+.\d mm, .* z = \d+.\d mm, where joint",
        ),
        (
            PICKING,
            START,
            (0.0, 0.0, -1.0),
            r"stroke of \+-60 deg; its end is \d+.\d mm out of reach: the nearest reachable position is x =",
        ),
        (SEVEN, at, (1.5, 0.0, 0.0), r"leaves its stroke of \+-60 deg.*; its end is"),
    ],
)
def test_a_line_that_the_arm_can_not_follow_is_refused(
    machine: Machine, start: np.ndarray, way: tuple[float, ...], expected: str
) -> None:
    tip = tip_position(machine, start)
    with pytest.raises(InputError, match=f"^here: leaves the arm's .*{expected}") as caught:
        SpacePath(machine, LineCurve.from_points(tuple(tip), tuple(tip + way), "here"), start, "here").check_reachable()
    assert "\n" not in str(caught.value)


def test_the_border_is_where_the_reach_ends() -> None:
    """By inverse kinematics: up to there a posture is found, and of an arm without joints to spare none beyond."""
    arm, draw = random_arm(3, 1), np.random.default_rng(4)
    half, inverse = half_strokes(arm), InverseKinematics(arm)
    checked = 0
    while checked < 5:
        start, way = draw.uniform(-0.6 * half, 0.6 * half), draw.normal(size=3)
        way, tip = way / np.linalg.norm(way), tip_position(arm, start)
        if inverse.mobility(start[None])[0] < 0.1:
            continue
        path = SpacePath(arm, LineCurve(tuple(tip), tuple(way), 2.0), start, "line")
        border = path.reach_limit(2.0)
        assert border is not None
        near = path.evaluate(np.array([border - 1e-6])).value
        assert np.all(np.abs(near) <= half + 1e-6)
        at_end = np.abs(near[0]).max() > half[0] - 1e-3
        assert at_end or inverse.mobility(near)[0] < 0.01
        checked += 1


def test_motions_in_space_keep_their_limits() -> None:
    _, path = WAYS["arc"]
    tip = TipLimits(speed=0.5, acceleration=3.0)
    for motion in (
        plan_time_optimal(PICKING, path, tip=tip),
        plan_jerk_limited(PICKING, path, tip=tip._replace(jerk=60.0)),
    ):
        states = motion.states(np.linspace(0.0, motion.duration, 401))
        speed, acceleration = (np.linalg.norm(of, axis=1).max() for of in tip_motion(PICKING, *states))
        assert 0.95 * 0.5 < speed < 1.01 * 0.5
        assert acceleration < 1.06 * 3.0  # between the nodes of the grid
        assert np.all(np.abs(states.velocities) < joint_capabilities(PICKING).speed)
        assert_allclose(
            tip_position(PICKING, states.angles[[0, -1]]),
            path.curve.evaluate(np.array([0.0, path.length])).value,
            atol=1e-9,
        )


def test_a_level_belt_is_followed_there_and_back() -> None:
    speeds = [(0.0, 0.2), (0.4, -0.3), (1.2, 0.0)]
    motion = follow_belt(PICKING, START, np.radians(-80.0), speeds, 4.0)
    states = motion.states(np.linspace(0.0, motion.duration, 301))
    tips = tip_position(PICKING, states.angles)
    assert motion.reach_exit is None
    assert_allclose(tips[:, 2], TIP[2], atol=1e-9)
    along = (tips - TIP) @ [np.cos(np.radians(-80.0)), np.sin(np.radians(-80.0)), 0.0]
    assert along.max() > 0.05
    assert along.min() < -0.05
    assert np.abs(np.diff(states.velocities, axis=0)).max() < 0.2  # nothing jumps where it goes back beyond its start
    away = follow_belt(PICKING, START, np.radians(20.0), [(0.0, 0.5), (2.0, 0.0)], 4.0)
    assert away.reach_exit is not None
    assert len(away.reach_exit.position) == 3
    assert_allclose(tip_position(PICKING, away.path.evaluate(np.array([0.0])).value)[0], TIP, atol=1e-12)
    end = Kinematics(PICKING).tip(away.angles_at([away.duration]))[0]
    assert_allclose(end, away.reach_exit.position, atol=1e-6)
