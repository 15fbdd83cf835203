import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from layflat.identify.benches import simulate_candidates
from layflat.identify.benches.rod.laws import Rod, RodLog, film_force, profile_at, rod_force, slip_force, smooth_force

VISCOUS = Rod(
    area=5e-4,
    area_slope=1e-3,
    spring=20.0,
    offset=3.0,
    base=6.0,
    slope=1e-5,
    viscous=80.0,
    area_growth=0.0,
    area_slope_growth=0.0,
    film_fraction=0.0,
    film_speed=0.004,
    weights=(1.0,),
    stiffness=(1e5,),
)


def test_force_by_hand() -> None:
    # 5e-4 * 4e5 + 1e-3 * 0.01 * 4e5 + 3 + 20 * 0.01 + 80 * 0.05
    assert smooth_force(VISCOUS, 0.01, 0.05, 4e5, 4e5) == pytest.approx(200.0 + 4.0 + 3.0 + 0.2 + 4.0)


@given(st.floats(-0.05, 0.05), st.floats(0.0, 8e5))
def test_gas_gives_back_the_work_that_was_done_on_it(x: float, p: float) -> None:
    """At constant pressure the force depends on where the rod is alone, whichever way it goes."""
    still = VISCOUS._replace(viscous=0.0)
    assert smooth_force(still, x, 0.1, p, p) == smooth_force(still, x, -0.1, p, p)


def test_friction_grows_with_pressure_above_that_outside() -> None:
    assert slip_force(VISCOUS, 0.0, 2e5) == pytest.approx(8.0)
    assert slip_force(VISCOUS, 0.0, -0.5e5) == pytest.approx(6.0)


def test_a_seal_keeps_the_shape_of_the_pressure_at_which_it_is_held() -> None:
    shaped = VISCOUS._replace(area_growth=2e-11, area_slope_growth=-3e-10)
    # (2e-11 - 3e-10 * 0.01) * (4e5)^2, whatever the regulator lets through
    for p_g in (3.9e5, 4e5, 4.2e5):
        added = smooth_force(shaped, 0.01, 0.0, p_g, 4e5) - smooth_force(VISCOUS, 0.01, 0.0, p_g, 4e5)
        assert added == pytest.approx(2.72)


@given(st.floats(-0.5, 0.5), st.floats(0.0, 20.0), st.floats(0.0, 1.0))
def test_a_film_never_pushes_and_takes_no_more_than_its_share(v: float, level: float, share: float) -> None:
    film = VISCOUS._replace(film_fraction=share)
    force = film_force(film, v, level)
    assert force * v >= 0.0
    assert abs(force) <= share * level
    assert film_force(film, -v, level) == -force


@given(st.floats(-0.05, 0.1))
def test_a_profile_is_linear_between_its_places_and_flat_beyond(x: float) -> None:
    items, places = (0.1, -0.2, 0.3, 0.0), np.linspace(0.01, 0.04, 4)
    uneven = VISCOUS._replace(profile=items, profile_from=0.01, profile_step=0.01)
    assert profile_at(uneven, x) == pytest.approx(np.interp(x, places, items), abs=1e-12)
    assert slip_force(uneven, x, 2e5) == pytest.approx(8.0 * (1.0 + np.interp(x, places, items)))


def test_friction_is_never_negative() -> None:
    assert slip_force(VISCOUS._replace(profile=(-1.5, -1.5)), 0.0, 2e5) == 0.0


ROD = Rod(
    area=5e-4, area_slope=1e-3, area_growth=0.0, area_slope_growth=0.0, spring=20.0, offset=3.0, base=6.0, slope=1e-5,
    viscous=0.0, film_fraction=0.0, film_speed=0.004,
    weights=(0.5, 0.3, 0.2), stiffness=(5e4, 6e3, 1e3),
)  # fmt: skip
X = 0.02 * np.sin(np.linspace(0.0, 4 * np.pi, 2000))


def rod_log(first: float = 206.0) -> RodLog:
    return RodLog(X, np.zeros_like(X), np.full_like(X, 4e5), first, 4e5)


def forces(rod: Rod, log: RodLog, count: int = 1) -> NDArray[np.float64]:
    return simulate_candidates(rod_force, count, [(rod, log)], [X.shape])[0]


def test_a_rod_that_slips_asks_for_gas_spring_and_all_of_the_friction() -> None:
    force = forces(ROD, rod_log())[0]
    for i, way in ((500, -1.0), (1000, 1.0), (1500, -1.0)):
        expected = (5e-4 + 1e-3 * X[i]) * 4e5 + 3.0 + 20.0 * X[i] + way * 10.0
        assert force[i] == pytest.approx(expected, abs=1e-9)


def test_the_first_sample_is_met_as_far_as_the_friction_allows() -> None:
    for first, expected in ((206.0, 206.0), (150.0, 193.0), (300.0, 213.0)):
        force = forces(ROD, rod_log(first))[0]
        assert force[0] == pytest.approx(expected, abs=1e-9)


def test_candidates_do_not_depend_on_each_other() -> None:
    bases = np.linspace(0.0, 9.0, 7)
    many = forces(ROD._replace(base=bases), rod_log(), 7)  # type: ignore[arg-type]
    for base, found in zip(bases, many, strict=True):
        np.testing.assert_array_equal(found, forces(ROD._replace(base=base), rod_log())[0])
