"""Moving targets: the tip is where the belt's point is, as long as the arm reaches it, and stops where it does not."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from layflat.errors import InputError
from layflat.machine import load
from layflat.motion.belt import BeltMotion, follow_belt
from layflat.motion.kinematics import tip_motion, tip_position
from layflat.motion.planar import PlanarReach

ARM = load("paper-arm-fast")
MIDDLE = np.zeros(2)
TIP = tip_position(ARM, MIDDLE)
GIVEN = st.floats(-0.6, 0.6).filter(lambda speed: abs(speed) > 1e-3)


def seen(motion: BeltMotion) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return times, and position, velocity and acceleration of the tip."""
    times = np.linspace(0.0, motion.duration, 3001)
    states = motion.states(times)
    return times, tip_position(ARM, states.angles), *tip_motion(ARM, *states)


def test_the_tip_has_the_speeds_of_the_belt() -> None:
    """Which starts, turns back, and stops; each change takes 1.5 |dv| / a."""
    speeds = [(0.1, 0.3), (0.5, -0.2), (1.2, 0.0)]
    motion = follow_belt(ARM, MIDDLE, radians(90), speeds, 3.0)
    assert motion.reach_exit is None
    assert motion.duration == pytest.approx(1.2 + 1.5 * 0.2 / 3.0)
    times, x, v, a = seen(motion)
    for since, until, speed in ((0.0, 0.1, 0.0), (0.25, 0.5, 0.3), (0.75, 1.2, -0.2), (1.3, 9.0, 0.0)):
        part = v[(times >= since) & (times <= until)]
        assert_allclose(part, np.tile([0.0, speed], (len(part), 1)), atol=1e-12)
    assert_allclose(x[:, 0], TIP[0], atol=1e-12)
    assert np.linalg.norm(a, axis=1).max() == pytest.approx(3.0, rel=1e-4)
    travelled = 0.3 * (0.4 - 0.075) + 0.05 * 0.25 - 0.2 * (0.7 - 0.25 + 0.05)
    assert x[-1, 1] - TIP[1] == pytest.approx(travelled)


@given(st.floats(-180, 180), st.lists(st.tuples(st.floats(0.0, 0.5), GIVEN), min_size=1, max_size=4), st.floats(1, 8))
def test_what_leaves_the_reach_is_left_without_a_jump(
    direction: float, steps: list[tuple[float, float]], acceleration: float
) -> None:
    speeds, at, last = [], 0.0, 0.0
    for pause, speed in [*steps, (0.5, 0.0)]:
        speeds.append((at + pause, speed))
        at, last = at + pause + 1.5 * abs(speed - last) / acceleration, speed
    motion = follow_belt(ARM, MIDDLE, radians(direction), speeds, acceleration)
    times, x, v, a = seen(motion)
    reach = PlanarReach(ARM, margin=0.0)
    assert max(reach.distance_outside(*point) for point in x[::50].tolist()) < 1e-6
    assert np.linalg.norm(a, axis=1).max() <= acceleration * 1.01
    assert np.linalg.norm(v, axis=1).max() <= max(abs(speed) for _, speed in speeds) + 1e-9
    assert_allclose(np.diff(x, axis=0), 0.5 * (v[1:] + v[:-1]) * np.diff(times)[:, None], atol=1e-5)
    assert_allclose(v[[0, -1]], 0.0, atol=1e-9)
    along = (x - TIP) @ [cos(radians(direction)), sin(radians(direction))]
    assert_allclose(x - TIP, along[:, None] * [cos(radians(direction)), sin(radians(direction))], atol=1e-9)
    if motion.reach_exit is not None:
        assert_allclose(x[-1], motion.reach_exit.position, atol=1e-8)
        assert 0.0 < motion.reach_exit.time < motion.duration
        beyond = np.array(motion.reach_exit.position) + 1e-5 * np.sign(along[-1]) * np.array(
            [cos(radians(direction)), sin(radians(direction))]
        )
        assert reach.distance_outside(*beyond.tolist()) > 0.0


def test_a_target_leaves_when_it_is_at_the_border_and_the_tip_stops_there() -> None:
    """With a constant speed: the time is that of the distance."""
    motion = follow_belt(ARM, MIDDLE, 0.0, [(0.0, 0.4), (2.0, 0.0)], 4.0)
    assert motion.reach_exit is not None
    distance = motion.reach_exit.position[0] - TIP[0]
    assert motion.reach_exit.time == pytest.approx(distance / 0.4 + 0.75 * 0.4 / 4.0)
    times, _, v, _ = seen(motion)
    # The tip brakes for 1.5 v / a over half of that times v: it stops so much later as the target passes.
    stopped = times[np.linalg.norm(v, axis=1) > 1e-9][-1]
    assert stopped == pytest.approx(motion.reach_exit.time + 0.75 * 0.4 / 4.0, abs=2e-3)


@pytest.mark.parametrize("speeds", [[(0.0, 0.2), (1.0, 0.0)], [(0.3, 0.2), (1.0, -0.2), (2.0, 0.0)]])
def test_a_target_that_begins_at_the_border_is_let_go(speeds: list[tuple[float, float]]) -> None:
    stretched = np.radians([0.0, -60.0])
    motion = follow_belt(ARM, stretched, radians(30), speeds, 3.0)
    assert motion.reach_exit is not None
    assert_allclose(motion.angles_at([0.0, 1.0, motion.duration]), [stretched] * 3, atol=1e-9)


def test_a_target_that_turns_before_the_border_is_not_left() -> None:
    far = follow_belt(ARM, MIDDLE, 0.0, [(0.0, 0.4), (2.0, 0.0)], 4.0)
    assert far.reach_exit is not None
    until = far.reach_exit.time - 0.02 - 0.75 * 0.4 / 4.0  # it stops 8 mm before the border
    near = follow_belt(ARM, MIDDLE, 0.0, [(0.0, 0.4), (until, 0.0)], 4.0)
    assert near.reach_exit is None
    assert far.reach_exit.position[0] - tip_position(ARM, near.angles_at([9.0])[0])[0] == pytest.approx(0.4 * 0.02)


@pytest.mark.parametrize(
    ("speeds", "expected"),
    [
        ([(0.0, 0.3)], r"ends with 0.3 m/s, not at rest; give speeds such as"),
        ([(0.0, 0.0)], "does not move"),
        ([], "does not move"),
        ([(0.0, 0.3), (0.1, 0.0)], r"begins to change its speed at 0.1 s, while it changes until 0.15 s; give a later"),
    ],
)
def test_belts_that_make_no_sense_are_refused(speeds: list[tuple[float, float]], expected: str) -> None:
    with pytest.raises(InputError, match=f"^here: {expected}"):
        follow_belt(ARM, MIDDLE, 0.0, speeds, 3.0, "here")


def test_a_change_may_begin_as_the_last_one_ends() -> None:
    back_to_back = follow_belt(ARM, MIDDLE, 0.0, [(0.0, 0.3), (0.15, 0.0)], 3.0)
    assert back_to_back.duration == pytest.approx(0.3)
    assert tip_position(ARM, back_to_back.angles_at([0.3])[0])[0] - TIP[0] == pytest.approx(0.3 * 0.15)
