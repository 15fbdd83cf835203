import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.adjustable import (
    FULL_FRACTIONS,
    NONE_ADJUSTABLE,
    NOT_ADJUSTABLE,
    DriveFractions,
    FractionLimits,
    JointFractionLimits,
    adjust_fractions,
    regulated_pressure,
)

SHARE = st.floats(0.0, 1.0)
RATE = st.floats(0.1, 1e4)


def with_brake(limits: FractionLimits) -> JointFractionLimits:
    return NONE_ADJUSTABLE._replace(brake=limits)


@given(asked=st.lists(st.floats(-1.0, 3.0), min_size=3, max_size=3), T=st.floats(1e-4, 1.0))
def test_what_is_fixed_stays_whole_to_the_last_bit(asked: list[float], T: float) -> None:
    assert adjust_fractions(NONE_ADJUSTABLE, FULL_FRACTIONS, DriveFractions(*asked), T) == (
        FULL_FRACTIONS,
        FULL_FRACTIONS,
    )


@given(least=SHARE, rate=RATE, begin=SHARE, asked=st.floats(-0.5, 1.5), T=st.floats(1e-3, 0.1))
def test_a_share_goes_towards_what_is_asked_no_faster_than_its_rate_and_within_limits(
    least: float, rate: float, begin: float, asked: float, T: float
) -> None:
    begin, to = max(begin, least), min(max(asked, least), 1.0)
    mean, after = adjust_fractions(
        with_brake(FractionLimits(least, rate)),
        FULL_FRACTIONS._replace(brake=begin),
        FULL_FRACTIONS._replace(brake=asked),
        T,
    )
    times = np.linspace(0.0, T, 4001)
    course = begin + np.clip(to - begin, -rate * times, rate * times)
    assert after.brake == pytest.approx(course[-1], abs=1e-12)
    assert mean.brake == pytest.approx(np.trapezoid(course, times) / T, abs=1e-3)
    assert (mean.dither, mean.supply, after.dither, after.supply) == (1.0, 1.0, 1.0, 1.0)


def test_each_share_has_limits_of_its_own() -> None:
    limits = JointFractionLimits(FractionLimits(0.1, 1e6), NOT_ADJUSTABLE, FractionLimits(0.4, 1e6))
    _, after = adjust_fractions(limits, FULL_FRACTIONS, DriveFractions(0.0, 0.0, 0.0), 5e-3)
    assert after == pytest.approx((0.1, 1.0, 0.4))


@given(share=SHARE)
def test_a_regulator_gives_a_share_of_the_gauge_pressure(share: float) -> None:
    assert regulated_pressure(share, 5e5, 1e5) - 1e5 == pytest.approx(share * 4e5, abs=1e-9)
    assert regulated_pressure(1.0, 5e5, 1e5) == 5e5
