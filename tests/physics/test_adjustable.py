import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.adjustable import ALL_FIXED, FIXED, FULL, Adjustable, Adjustables, Shares, adjusted, regulated

SHARE = st.floats(0.0, 1.0)
RATE = st.floats(0.1, 1e4)


def with_brake(limits: Adjustable) -> Adjustables:
    return ALL_FIXED._replace(brake=limits)


@given(asked=st.lists(st.floats(-1.0, 3.0), min_size=3, max_size=3), T=st.floats(1e-4, 1.0))
def test_what_is_fixed_stays_whole_to_the_last_bit(asked: list[float], T: float) -> None:
    assert adjusted(ALL_FIXED, FULL, Shares(*asked), T) == (FULL, FULL)


@given(least=SHARE, rate=RATE, begin=SHARE, asked=st.floats(-0.5, 1.5), T=st.floats(1e-3, 0.1))
def test_a_share_goes_towards_what_is_asked_no_faster_than_its_rate_and_within_limits(
    least: float, rate: float, begin: float, asked: float, T: float
) -> None:
    begin, to = max(begin, least), min(max(asked, least), 1.0)
    mean, after = adjusted(
        with_brake(Adjustable(least, rate)), FULL._replace(brake=begin), FULL._replace(brake=asked), T
    )
    times = np.linspace(0.0, T, 4001)
    course = begin + np.clip(to - begin, -rate * times, rate * times)
    assert after.brake == pytest.approx(course[-1], abs=1e-12)
    assert mean.brake == pytest.approx(np.trapezoid(course, times) / T, abs=1e-3)
    assert (mean.dither, mean.supply, after.dither, after.supply) == (1.0, 1.0, 1.0, 1.0)


def test_each_share_has_limits_of_its_own() -> None:
    limits = Adjustables(Adjustable(0.1, 1e6), FIXED, Adjustable(0.4, 1e6))
    _, after = adjusted(limits, FULL, Shares(0.0, 0.0, 0.0), 5e-3)
    assert after == pytest.approx((0.1, 1.0, 0.4))


@given(share=SHARE)
def test_a_regulator_gives_a_share_of_the_gauge_pressure(share: float) -> None:
    assert regulated(share, 5e5, 1e5) - 1e5 == pytest.approx(share * 4e5, abs=1e-9)
    assert regulated(1.0, 5e5, 1e5) == 5e5
