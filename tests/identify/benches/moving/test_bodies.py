"""Links as torques see them: the way there and back, and that torques are linear there."""

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from layflat.arrays import Array
from layflat.description.change import changed_all, replace_value
from layflat.identify.benches.moving.blocks import machine_unknowns, sample_torques
from layflat.identify.benches.moving.bodies import STRENGTH_PATHS, BodyScaling, feasible_columns
from layflat.machine import Machine, load
from layflat.physics.arms.chain.description import describe_inertia_defect, six_moments


def whole(machine: Machine) -> Machine:
    """The same with all six moments of inertia of every link."""
    for name, link in machine.arm.link.items():
        machine = replace_value(machine, ["arm", "link", name, "inertia"], six_moments(link.inertia))
    return machine


ARMS = {name: load(name) for name in ("picking-arm", "single-joint-lift")}
ARMS["whole"] = whole(ARMS["picking-arm"])
SOUGHT = {name: machine_unknowns(machine, ["inertia"]) for name, machine in ARMS.items()}
SHARES = {name: BodyScaling(machine, SOUGHT[name]) for name, machine in ARMS.items()}

names, seeds = st.sampled_from(list(ARMS)), st.integers(0, 2**32 - 1)


def anywhere(name: str, seed: int, least: float = 0.0, most: float = 1.0) -> Array:
    """Shares of a candidate."""
    return np.random.default_rng(seed).uniform(least, most, len(SOUGHT[name]))


def machine_of(name: str, values: Array) -> Machine:
    """An arm with other values."""
    return changed_all(ARMS[name], {one.path: float(v) for one, v in zip(SOUGHT[name], values, strict=True)})


@given(names, seeds)
def test_the_way_back_leads_to_the_same(name: str, seed: int) -> None:
    shares, scaled = anywhere(name, seed), SHARES[name]
    assert scaled.scale(scaled.unscale(shares)) == pytest.approx(shares, abs=1e-9)
    guess = np.array([one.guess for one in SOUGHT[name]])
    assert scaled.unscale(scaled.scale(guess)) == pytest.approx(guess, rel=1e-9, abs=1e-12)


def test_torques_are_linear_in_these_shares_and_not_in_those_of_the_values() -> None:
    guess, away = np.array([one.guess for one in SOUGHT["whole"]]), anywhere("whole", 1, -1e-3, 1e-3)
    bent = []
    for scaled in (SHARES["whole"], SHARES["whole"].plain):
        points = [scaled.unscale(scaled.scale(guess) + k * away) for k in (-1.0, 0.0, 1.0)]
        low, middle, high = (sample_torques(machine_of("whole", values)) for values in points)
        bent.append(np.max(np.abs(0.5 * (low + high) - middle)) / np.max(np.abs(high - low)))
    assert bent[0] < 1e-12
    assert bent[1] > 1e-5


def missing(name: str, columns: Mapping[str, Array]) -> set[str]:
    """Why links are no bodies."""
    moments = {
        link: tuple(
            columns.get(f"arm.link.{link}.inertia.{i}", np.array([value])) for i, value in enumerate(part.inertia)
        )
        for link, part in ARMS[name].arm.link.items()
    }
    return {what for inertia in moments.values() if (what := describe_inertia_defect(inertia))}


def columns_of(name: str, values: Array) -> dict[str, Array]:
    """Values of a candidate by path."""
    return {one.path: values[None, i] for i, one in enumerate(SOUGHT[name])}


@given(names, seeds)
def test_whatever_is_tried_is_a_body(name: str, seed: int) -> None:
    values = SHARES[name].unscale(np.clip(anywhere(name, seed, -0.5, 1.5), 0.0, 1.0))
    assert missing(name, feasible_columns(ARMS[name], columns_of(name, values))) == set()


def made(name: str, shares: Array) -> Array:
    """Shares of the bodies that a candidate is taken for."""
    columns = feasible_columns(ARMS[name], columns_of(name, SHARES[name].unscale(shares)))
    return SHARES[name].scale(np.array([columns[one.path][0] for one in SOUGHT[name]]))


def torques_by_shares() -> Array:
    """How torques change by shares of the arm with all moments, over their greatest, (torques, shares)."""
    scaled, small = SHARES["whole"], 1e-4 * np.eye(len(SOUGHT["whole"]))
    guess = scaled.scale(np.array([one.guess for one in SOUGHT["whole"]]))
    up, down = (
        [sample_torques(machine_of("whole", scaled.unscale(guess + way))).ravel() for way in w] for w in (small, -small)
    )
    slopes = (np.array(up) - np.array(down)).T / 2e-4
    return np.asarray(slopes / np.abs(slopes).max())


def test_bodies_are_found_that_act_as_what_no_body_can_be() -> None:
    scaled, slopes = SHARES["whole"], torques_by_shares()
    felt = np.linalg.svd(slopes, full_matrices=False)[2]
    hidden = (np.eye(slopes.shape[1]) - felt.T @ felt) @ anywhere("whole", 0, -1.0, 1.0)  # acts on no joint
    guess = scaled.scale(np.array([one.guess for one in SOUGHT["whole"]]))
    assert np.max(np.abs(slopes @ hidden)) < 1e-12
    asked = guess + 0.1 * hidden
    assert missing("whole", columns_of("whole", scaled.unscale(asked)))
    near = made("whole", asked)
    found = made("whole", scaled.project(asked, near, np.vstack([1e6 * slopes, np.eye(len(asked))])))
    clipped, settled = (np.max(np.abs(slopes @ (shares - asked))) for shares in (near, found))
    assert settled < 1e-2 * clipped


@pytest.mark.parametrize("seed", range(2))
def test_all_else_gives_way_to_bodies_within_its_bounds(seed: int) -> None:
    scaled, draw = SHARES["picking-arm"], np.random.default_rng(seed)
    others = np.setdiff1d(np.arange(len(scaled.low)), np.concatenate([body.places for body in scaled.bodies]))
    asked = anywhere("picking-arm", seed, 0.3, 0.7)
    near = made("picking-arm", asked)
    asked[others] += 2.0 * draw.choice([-1.0, 1.0], len(others))  # nowhere near what they may be
    near[others] = np.clip(asked[others], 0.0, 1.0)
    triangle = np.triu(draw.standard_normal((len(asked), len(asked)))) + 3.0 * np.eye(len(asked))
    found = scaled.project(asked, near, triangle)
    assert np.all((found[others] >= 0.0) & (found[others] <= 1.0))
    assert made("picking-arm", found) == pytest.approx(found, abs=1e-3)  # but for rounding
    assert np.linalg.norm(triangle @ (found - asked)) < 0.9 * np.linalg.norm(triangle @ (near - asked))


@given(names, seeds)
@example("picking-arm", 512)  # as thin as a body may be
def test_roots_come_back_as_the_body_that_they_are_of(name: str, seed: int) -> None:
    values = SHARES[name].unscale(anywhere(name, seed))
    columns = feasible_columns(ARMS[name], columns_of(name, values))
    values = np.array([columns[one.path][0] for one in SOUGHT[name]])
    for body in SHARES[name].bodies:
        assert body.from_free(body.to_free(values)) == pytest.approx(values[body.places], rel=1e-6, abs=1e-12)


def test_an_arm_that_is_stronger_and_heavier_as_a_whole_lies_along_a_straight_line() -> None:
    arm = ARMS["whole"]
    sought = machine_unknowns(arm, ["valve", "hose", "friction", "inertia"])
    guess, scaled = np.array([one.guess for one in sought]), BodyScaling(arm, sought)
    grows = np.array([any(part in f".{one.path}" for part in (*STRENGTH_PATHS, ".mass", "inertia")) for one in sought])
    once, twice, thrice = (scaled.scale(np.where(grows, k * guess, guess)) for k in (1.0, 2.0, 3.0))
    assert twice - once == pytest.approx(thrice - twice, abs=1e-9)
    assert np.count_nonzero(twice - once) > 0.5 * len(sought)


@given(names, seeds)
def test_shares_of_the_values_themselves_change_by_those_searched_as_told(name: str, seed: int) -> None:
    scaled, shares, step = SHARES[name], anywhere(name, seed, 0.3, 0.7), 1e-5
    own, slopes = scaled.to_plain(shares)
    assert scaled.plain.unscale(own) == pytest.approx(scaled.unscale(shares), rel=1e-9, abs=1e-12)
    way = np.random.default_rng(seed).standard_normal(len(own))
    ahead, behind = (scaled.plain.scale(scaled.unscale(shares + k * step * way)) for k in (1.0, -1.0))
    told = slopes @ way
    assert told == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-4, abs=1e-4 * np.max(np.abs(told)))


def test_a_share_of_the_values_themselves_is_its_own() -> None:
    plain, shares = SHARES["picking-arm"].plain, anywhere("picking-arm", 0)
    own, slopes = plain.to_plain(shares)
    assert plain.plain is plain
    assert own is shares
    assert np.array_equal(slopes, np.eye(len(shares)))
