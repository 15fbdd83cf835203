from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from layflat.physics.valves.spool_laws import Spool, StictionSpool, advance_spool

WN = 2 * pi * 80.0
SPOOL = Spool(WN, 0.7, 0.05)


def settle(spool: Spool | StictionSpool, u: float, x: float = 0.0, dither: float = 0.0, seconds: float = 0.5) -> float:
    """Mean position over the last dither period."""
    h, v, path = 2.5e-4, 0.0, []
    for k in range(round(seconds / h)):
        x, v = advance_spool(spool, u + dither * np.sin(2 * pi * 50.0 * (k + 0.5) * h), 0.0, x, v, h)
        path.append(x)
    return float(np.mean(path[-80:]))


@pytest.mark.parametrize("u", [-0.049, 0.0, 0.03, 0.05])
def test_friction_hides_small_commands(u: float) -> None:
    assert settle(SPOOL, u) == 0.0


@pytest.mark.parametrize("u", [-0.2, 0.051, 0.3])
def test_a_larger_command_moves_it(u: float) -> None:
    x = settle(SPOOL, u)
    assert abs(x) > 1e-4
    assert abs(x - u) <= SPOOL.friction + 1e-12


@pytest.mark.parametrize("u", [-0.03, 0.02, 0.05, 0.2])
def test_dither_makes_it_follow(u: float) -> None:
    assert settle(SPOOL, u, dither=0.15) == pytest.approx(u, abs=2e-3)


@given(st.floats(-0.5, 0.5), st.floats(-0.049, 0.049))
def test_a_stuck_spool_stays_exactly(x: float, pull: float) -> None:
    assert advance_spool(SPOOL, x + pull, 0.0, x, 0.0, 2.5e-4) == (x, 0.0)


def driven(h: float, friction: float) -> float:
    x, v = 0.0, 0.0
    for k in range(round(0.06 / h)):
        x, v = advance_spool(
            Spool(WN, 0.7, friction),
            0.4 * np.sin(2 * pi * 20.0 * (k + 0.5) * h),
            0.2 * pi * 40.0 * h * np.cos(2 * pi * 20.0 * (k + 0.5) * h),
            x,
            v,
            h,
        )
    return x


@pytest.mark.parametrize("friction", [0.0, 0.05])
def test_second_order_in_the_step(friction: float) -> None:
    exact = driven(2e-6, friction)
    errors = [abs(driven(h, friction) - exact) for h in (4e-4, 2e-4, 1e-4, 5e-5)]
    order = np.polyfit(np.log([4e-4, 2e-4, 1e-4, 5e-5]), np.log(errors), 1)[0]
    assert order > 1.8


@given(st.floats(-0.5, 0.5), st.floats(0.06, 1.0), st.sampled_from([-1.0, 1.0]))
def test_a_spool_that_sets_off_takes_the_implicit_midpoint(x: float, pull: float, way: float) -> None:
    h = 2.5e-4
    after, v = advance_spool(SPOOL, x + way * pull, 0.0, x, 0.0, h)
    assert after == pytest.approx(x + 0.5 * h * v)
    force = WN**2 * (pull - 0.5 * abs(after - x) - SPOOL.friction)
    assert way * v == pytest.approx(h * (force - 2.0 * SPOOL.damping_ratio * WN * 0.5 * abs(v)))


def test_smooth_spool_against_scipy() -> None:
    def rates(t: float, y: NDArray[np.float64]) -> list[float]:
        return [y[1], WN**2 * (0.4 * np.sin(2 * pi * 20.0 * t) - y[0]) - 1.4 * WN * y[1]]

    reference = solve_ivp(rates, (0.0, 0.06), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert driven(1e-5, 0.0) == pytest.approx(reference, abs=2e-6)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_stops_hold_the_spool(side: float) -> None:
    spool = Spool(WN, 0.2, 0.05)
    x, v, path = 0.0, 0.0, []
    for _ in range(400):
        x, v = advance_spool(spool, side * 1.5, 0.0, x, v, 2.5e-4)
        path.append(x * side)
    assert max(path) == path[-1] == 1.0
    assert v == 0.0
    # Pulled away, it leaves the stop.
    x, v = advance_spool(spool, 0.0, 0.0, x, v, 2.5e-4)
    assert abs(x) < 1.0


@given(st.floats(-1.0, 1.0), st.floats(-300.0, 300.0))
def test_left_alone_it_loses_energy(x: float, v: float) -> None:
    free = Spool(WN, 0.7, 0.0)
    after_x, after_v = advance_spool(free, 0.0, 0.0, x, v, 2.5e-4)
    assert WN**2 * after_x**2 + after_v**2 <= (WN**2 * x**2 + v**2) * (1 + 1e-12)


STUBBORN = StictionSpool(WN, 0.7, 0.05, 0.6, 1.0 / 4.0**2)


@given(st.floats(-1.2, 1.2), st.floats(-0.3, 0.3), st.floats(-1.0, 1.0), st.floats(-100.0, 100.0))
def test_without_excess_stiction_is_coulomb_friction(u: float, du: float, x: float, v: float) -> None:
    plain = STUBBORN._replace(excess=0.0)
    assert advance_spool(plain, u, du, x, v, 2.5e-4) == advance_spool(SPOOL, u, du, x, v, 2.5e-4)


@given(st.floats(-0.5, 0.5), st.floats(-0.0799, 0.0799))
def test_stiction_holds_more_than_kinetic_friction(x: float, pull: float) -> None:
    assert advance_spool(STUBBORN, x + pull, 0.0, x, 0.0, 2.5e-4) == (x, 0.0)


@pytest.mark.parametrize("u", [-0.12, 0.12])
def test_torn_loose_it_goes_as_far_as_kinetic_friction_lets_it(u: float) -> None:
    assert settle(STUBBORN, np.sign(u) * 0.079) == 0.0
    assert 0.05 < abs(settle(STUBBORN, u)) <= 0.07, "past 0.04, where static friction would hold it"


def dragged(h: float) -> tuple[float, int]:
    """Position after a slow ramp of the command there and back, and how often the spool set off."""
    x, v, starts = 0.0, 0.0, 0
    for k in range(round(0.2 / h)):
        t = (k + 0.5) * h
        rate = 3.0 if t < 0.1 else -3.0
        before = v
        x, v = advance_spool(STUBBORN, 0.3 - 3.0 * abs(t - 0.1), 0.5 * rate * h, x, v, h)
        starts += before == 0.0 and v != 0.0
    return x, starts


def test_it_sticks_and_slips_as_with_the_finest_steps() -> None:
    exact, often = dragged(2.5e-6)
    assert often >= 3
    errors = []
    for h in (2.5e-4, 1.25e-4, 6.25e-5):
        x, starts = dragged(h)
        assert starts == often
        errors.append(abs(x - exact))
    assert errors[0] < 2e-3
    assert errors[2] < errors[0] / 3.0


@given(st.floats(-1.0, 1.0), st.floats(-300.0, 300.0))
def test_stiction_makes_no_energy(x: float, v: float) -> None:
    after_x, after_v = advance_spool(STUBBORN, 0.0, 0.0, x, v, 2.5e-4)
    assert WN**2 * after_x**2 + after_v**2 <= (WN**2 * x**2 + v**2) * (1 + 1e-12)
