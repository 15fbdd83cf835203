"""Inverse kinematics: the tip comes to its place, within the strokes, and as near as SciPy finds where it can't."""

from __future__ import annotations

import re
from time import process_time
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import NonlinearConstraint, least_squares, minimize

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine, changed, load
from layflat.motion.inverse import (
    MIN_MOBILITY,
    POSITION_TOLERANCE,
    TARGET_TOLERANCE,
    InverseKinematics,
    solve_inverse_kinematics,
)
from layflat.motion.kinematics import Kinematics, tip_motion, tip_position
from layflat.motion.path import half_strokes
from tests.physics.arms.chain.chains import as_chain, random_arm

ARMS = {
    "planar": load("paper-arm-fast"),
    "picking": load("picking-arm"),
    "four": random_arm(4, 2),
    "seven": random_arm(7, 2),
}
STRETCHED = changed(ARMS["planar"], "arm.elbow", 0.0)


def drawn(name: str, count: int, seed: int = 5) -> tuple[Array, Array]:
    """Postures within the strokes of an arm, and where they put the tip, in space."""
    half = half_strokes(ARMS[name])
    q = np.random.default_rng(seed).uniform(-half, half, (count, len(half)))
    return q, Kinematics(ARMS[name]).tip(q)


@pytest.mark.parametrize("name", ARMS)
def test_the_jacobian_is_what_moves_the_tip(name: str) -> None:
    q, tips = drawn(name, 20)
    kinematics = Kinematics(ARMS[name])
    assert_allclose(tips[:, : tip_position(ARMS[name], q).shape[1]], tip_position(ARMS[name], q), atol=1e-12)
    tip, jacobian = kinematics.tip_and_jacobian(q)
    assert_allclose(tip, tips, atol=1e-15)
    way, h = np.random.default_rng(1).normal(size=q.shape), 1e-6
    expected = (kinematics.tip(q + h * way) - kinematics.tip(q - h * way)) / (2 * h)
    assert_allclose(np.einsum("pxj,pj->px", jacobian, way), expected, atol=1e-8)
    assert_allclose(
        tip_motion(ARMS[name], q, way, 0.0 * way)[0], expected[:, : tip_position(ARMS[name], q).shape[1]], atol=1e-8
    )


@pytest.mark.parametrize("name", ARMS)
def test_random_places_within_reach_are_found(name: str) -> None:
    _, places = drawn(name, 300)
    found, half = solve_inverse_kinematics(ARMS[name], places), half_strokes(ARMS[name])
    assert found.reached.mean() >= 0.99
    assert np.all(np.abs(found.angles) <= half)
    apart = np.linalg.norm(Kinematics(ARMS[name]).tip(found.angles) - places, axis=1)
    assert_allclose(apart, found.distance, atol=1e-14)
    assert np.all(apart[found.reached] < POSITION_TOLERANCE)


def test_random_arms_of_three_joints_come_to_their_places() -> None:
    for seed in range(4):
        arm = random_arm(3, seed)
        half = half_strokes(arm)
        places = Kinematics(arm).tip(np.random.default_rng(seed).uniform(-half, half, (100, 3)))
        assert solve_inverse_kinematics(arm, places).reached.mean() >= 0.99


def test_a_place_has_the_same_answer_alone_and_among_others() -> None:
    _, places = drawn("four", 60)
    inverse = InverseKinematics(ARMS["four"])
    every = inverse.solve_globally(places)
    for k in (0, 17, 59):
        assert_array_equal(inverse.solve_globally(places[k : k + 1]).angles[0], every.angles[k])


def test_margins_are_kept() -> None:
    _, places = drawn("picking", 100)
    inverse = InverseKinematics(ARMS["picking"], margin=0.2)
    found = inverse.solve_globally(places)
    assert np.all(np.abs(found.angles) <= half_strokes(ARMS["picking"]) - 0.2 + 1e-15)
    assert 0.3 < found.reached.mean() < 1.0


class Way:
    """The way from the tip to a place, m, and its derivative, as SciPy wants them."""

    def __init__(self, name: str, place: Array) -> None:
        self._kinematics, self._place = Kinematics(ARMS[name]), place

    def __call__(self, q: Array) -> Array:
        way: Array = self._kinematics.tip(q[None])[0] - self._place
        return way

    def slope(self, q: Array) -> Array:
        slope: Array = self._kinematics.tip_and_jacobian(q[None])[1][0]
        return slope


@pytest.mark.parametrize("name", ["picking", "four", "seven"])
def test_no_posture_is_nearer(name: str) -> None:
    """Against sequential quadratic programmes that begin in what was found."""
    _, places = drawn(name, 8)
    wanted, _ = drawn(name, 8, seed=6)
    found, half = InverseKinematics(ARMS[name]).solve_near(places, wanted), half_strokes(ARMS[name])
    bounds = list(zip(-half, half, strict=True))
    assert found.reached.sum() >= 5
    for place, near, posture in zip(
        places[found.reached], wanted[found.reached], found.angles[found.reached], strict=True
    ):
        way = Way(name, place)

        def apart(q: Array, near: Array = near) -> tuple[float, Array]:
            return float(np.sum((q - near) ** 2)), 2.0 * (q - near)

        best = minimize(
            apart, posture, jac=True, method="SLSQP", bounds=bounds, options={"ftol": 1e-14, "maxiter": 200},
            constraints=[NonlinearConstraint(way, 0.0, 0.0, jac=way.slope)],
        )  # fmt: skip
        assert np.linalg.norm(posture - near) < np.sqrt(best.fun) + 2e-3


@pytest.mark.parametrize("name", ["planar", "picking", "four"])
def test_out_of_reach_nothing_is_nearer(name: str) -> None:
    """Against bounded least squares of SciPy from many postures."""
    inverse, half, draw = InverseKinematics(ARMS[name]), half_strokes(ARMS[name]), np.random.default_rng(7)
    places = inverse.tips.mean(axis=0) + 0.6 * inverse.size * draw.normal(size=(6, 3))
    places[:, 2] *= name != "planar"
    bounds = (-half - 1e-9, half + 1e-9)
    for place, missing in zip(places, inverse.solve_globally(places).distance, strict=True):
        way, starts = Way(name, place), draw.uniform(-0.95 * half, 0.95 * half, (12, len(half)))
        fits = [least_squares(way, start, jac=way.slope, bounds=bounds).cost for start in starts]
        assert missing < np.sqrt(2.0 * min(fits)) + 1e-5


@pytest.mark.parametrize("place", [(0.0, 0.0, 1.1), (0.0, 0.0, 1.2), (0.02, 0.01, 1.09), (0.0, 0.0, -0.5)])
def test_near_a_singular_axis_no_posture_that_is_not_singular_is_nearer(place: tuple[float, ...]) -> None:
    """Against SciPy's trust region with constraints from many postures; and none of it takes long."""
    arm = ARMS["picking"]
    inverse, half, draw = InverseKinematics(arm), half_strokes(arm), np.random.default_rng(11)
    inverse.solve_globally(inverse.tips[:1])
    begun = process_time()
    with pytest.raises(InputError) as caught:
        inverse.compute_configuration(np.array(place), np.zeros(4), "here")
    assert process_time() - begun < 2.0  # 0.1 s on an idle machine; it took 8 s
    offered = 1e-3 * np.array([float(text) for text in re.findall(r"= (-?[\d.]+) mm", str(caught.value))[3:]])
    starts: Any = draw.uniform(-half, half, (200_000, 4))
    starts = starts[inverse.mobility(starts) > 2.0 * MIN_MOBILITY]
    apart = np.linalg.norm(Kinematics(arm).tip(starts) - place, axis=1)

    def away(q: Any) -> Any:
        return float(np.sum((1e2 * (inverse.tip(q) - place)) ** 2))

    def mobile(q: Any) -> Any:
        return float(inverse.mobility(q[None])[0])

    for start in starts[np.argsort(apart)[:10]]:
        best = minimize(
            away, start, method="SLSQP", bounds=list(zip(-half, half, strict=True)),
            constraints=[NonlinearConstraint(mobile, 2.0 * MIN_MOBILITY, 1.0)],
            options={"ftol": 1e-10, "maxiter": 200},
        )  # fmt: skip
        if mobile(best.x) > 2.0 * MIN_MOBILITY - 1e-6:
            assert np.linalg.norm(offered - place) < 1e-2 * np.sqrt(best.fun) + 5e-4


@pytest.mark.parametrize("arm", [*ARMS.values(), STRETCHED, as_chain()])
def test_what_is_offered_instead_is_accepted(arm: Machine) -> None:
    """As it is told, to a tenth of a millimetre."""
    inverse, draw = InverseKinematics(arm), np.random.default_rng(8)
    axes = tip_position(arm, inverse.solve_globally(inverse.tips[:1]).angles).shape[1]
    for place in inverse.tips.mean(axis=0) + 0.8 * inverse.size * draw.normal(size=(5, 3)) * [1, 1, axes > 2]:
        with pytest.raises(InputError, match=r"^here: x = .* mm out of the arm's reach; the nearest") as caught:
            inverse.compute_configuration(place[:axes], np.zeros(len(half_strokes(arm))), "here")
        offered = 1e-3 * np.array([float(text) for text in re.findall(r"= (\S+) mm", str(caught.value))[axes:]])
        posture = inverse.compute_configuration(offered, np.zeros(len(half_strokes(arm))), "here")
        assert np.linalg.norm(tip_position(arm, posture) - offered) < TARGET_TOLERANCE
        assert inverse.mobility(posture[None])[0] > MIN_MOBILITY


def test_a_singular_posture_is_told_with_a_place_beside_it() -> None:
    inverse, straight = InverseKinematics(STRETCHED), np.radians([20.0, 0.0])
    with pytest.raises(
        InputError, match=r"in a singular configuration, such as stretched; the nearest regular position"
    ) as caught:
        inverse.compute_configuration(tip_position(STRETCHED, straight), straight, "--tip")
    _, _, x, y, apart = (float(text) for text in re.findall(r"(?:= |, )(-?[\d.]+) mm", str(caught.value)))
    assert 0.0 < apart < 1.0
    posture = inverse.compute_configuration(1e-3 * np.array([x, y]), straight, "--tip")
    assert inverse.mobility(posture[None])[0] > MIN_MOBILITY


def test_singular_postures_are_avoided_where_others_get_there() -> None:
    """Of random arms, places where the nearest posture may be singular."""
    arm = random_arm(4, 0)
    inverse, half = InverseKinematics(arm), half_strokes(arm)
    q = np.random.default_rng(2).uniform(-half, half, (20000, 4))
    singular = q[inverse.mobility(q) < MIN_MOBILITY]
    assert len(singular) > 10
    found = inverse.solve_globally(Kinematics(arm).tip(singular), singular)
    assert found.reached.all()
    assert (inverse.mobility(found.angles) > MIN_MOBILITY).mean() > 0.5


def test_arms_know_in_which_directions_they_move() -> None:
    assert [InverseKinematics(random_arm(n, 0)).directions for n in (2, 3, 4)] == [2, 3, 3]
    assert InverseKinematics(as_chain()).directions == 2
