from math import dist, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine import changed, load
from layflat.motion.kinematics import tip_position
from layflat.motion.planar import AMPLE_MARGIN, Angles, PlanarReach

ARM = load("paper-arm")
STRAIGHT = changed(ARM, "arm.elbow", 0.0)
"""Its elbow bends both ways."""
ANGLES = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)).map(lambda share: tuple(s * radians(57) for s in share))


@pytest.mark.parametrize("machine", [ARM, STRAIGHT])
@given(angles=ANGLES)
def test_every_posture_of_the_working_stroke_is_found_from_its_tip(machine: object, angles: Angles) -> None:
    reach = PlanarReach(machine)  # type: ignore[arg-type]
    x, y = reach.tip(angles)
    found = reach.configurations(x, y)
    assert any(np.allclose(one.angles, angles, atol=1e-6) for one in found)
    for one in found:
        assert reach.tip(one.angles) == pytest.approx((x, y), abs=1e-9)
        assert all(abs(q) <= radians(57) + 1e-9 for q in one.angles)
        assert one.margin == pytest.approx(radians(60) - max(map(abs, one.angles)), abs=1e-9)
    assert reach.distance_outside(x, y) == 0.0


def test_a_stretched_arm_is_in_reach_whichever_way_its_cosine_is_rounded() -> None:
    for q in np.linspace(-radians(57), radians(57), 401).tolist():
        found = BOTH.configurations(*BOTH.tip((q, 0.0)))
        assert any(np.allclose(one.angles, (q, 0.0), atol=1e-6) for one in found)


@given(x=st.floats(-1.0, 1.0), y=st.floats(-1.0, 1.0))
def test_what_is_out_of_reach_lacks_as_much_as_a_search_over_all_postures_finds(x: float, y: float) -> None:
    for machine, reach in ((ARM, REACH), (STRAIGHT, BOTH)):
        limits = [np.linspace(-limit, limit, 241) for limit in reach.limits]
        grid = np.stack(np.meshgrid(*limits, indexing="ij"), axis=-1)
        nearest = float(np.linalg.norm(tip_position(machine, grid) - [x, y], axis=-1).min())
        assert reach.distance_outside(x, y) == pytest.approx(nearest, abs=6e-3)


REACH, BOTH = PlanarReach(ARM), PlanarReach(STRAIGHT)


def test_a_stretched_elbow_has_two_mirrored_postures() -> None:
    first, second = BOTH.configurations(0.7, 0.1)
    assert first.angles[1] == pytest.approx(-second.angles[1])
    assert first.margin >= second.margin


def test_both_elbows_move_the_tip_as_far_if_joints_are_off() -> None:
    """It tells good places from bad ones, not elbows; 1.6 mm at mid-stroke of the paper's arm (docs/cell-plan.md)."""

    def way(reach: PlanarReach, angles: Angles) -> float:
        off = [np.array(angles) + radians(0.1) * np.array(signs) for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
        return max(dist(reach.tip(tuple(one.tolist())), reach.tip(angles)) for one in off)

    first, second = BOTH.configurations(0.7, 0.1)
    assert way(BOTH, first.angles) == pytest.approx(way(BOTH, second.angles), rel=3e-3)
    assert way(REACH, (0.0, 0.0)) == pytest.approx(1.6e-3, abs=5e-5)


def test_the_quicker_posture_is_taken_unless_it_lacks_margin() -> None:
    x, y = 0.74, 0.05
    first, second = BOTH.configurations(x, y)
    assert min(first.margin, second.margin) > AMPLE_MARGIN
    for here in (first, second):
        chosen = BOTH.choose_configuration(x, y, lambda angles, here=here: abs(angles[1] - here.angles[1]))  # type: ignore[misc]
        assert chosen == here
    near_end = BOTH.tip((radians(55), radians(30)))
    tight = BOTH.choose_configuration(*near_end, lambda angles: 0.0 if angles[0] > 0.9 else 9.0)
    assert tight is not None
    assert tight.margin == max(one.margin for one in BOTH.configurations(*near_end))
    assert REACH.choose_configuration(1.0, 0.0, len) is None


def tip(q_1: float, q_2: float) -> tuple[float, float]:
    """Of the paper's arm, by complex numbers."""
    at = 0.4 * np.exp(1j * q_1) * (1 + np.exp(1j * (q_2 + np.pi / 2)))
    return float(at.real), float(at.imag)


@given(st.floats(-2.2, 2.2), st.floats(-2.2, 2.2))
def test_what_the_arm_reaches_is_where_its_tip_comes(q_1: float, q_2: float) -> None:
    limit = np.pi / 3
    if max(abs(q_1), abs(q_2)) < limit - 1e-6:
        assert PlanarReach(ARM, margin=0.0).distance_outside(*tip(q_1, q_2)) == 0.0


def test_nothing_else_is_reached() -> None:
    q = np.linspace(-np.pi / 3, np.pi / 3, 161)
    at = 0.4 * np.exp(1j * q[:, None]) * (1 + np.exp(1j * (q[None, :] + np.pi / 2)))
    rng, reach = np.random.default_rng(0), PlanarReach(ARM, margin=0.0)
    for x, y in rng.uniform(-0.85, 0.85, (200, 2)):
        if np.abs(at - (x + 1j * y)).min() > 1e-2:
            assert reach.distance_outside(x, y) > 0.0
