from math import exp

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.rig.device.virtual import DUMP_TIME, FILL_TIME, SOFT_TIME, SupplyLine

AMBIENT, REGULATOR = 101325.0, 501325.0

spans = st.floats(1e-4, 0.5)


def line(*, air: bool) -> SupplyLine:
    return SupplyLine(REGULATOR, AMBIENT, air=air)


def test_it_begins_where_it_would_stay() -> None:
    for air, pressure in ((True, REGULATOR), (False, AMBIENT)):
        at_first = line(air=air)
        assert at_first.pressure == pressure
        assert at_first.is_steady
        at_first.advance(1.0)
        assert at_first.pressure == pressure


def test_it_fills_softly_to_half_and_then_at_once() -> None:
    filling = line(air=False)
    filling.air = True
    half = SOFT_TIME * 0.6931471805599453
    filling.advance(0.999 * half)
    assert filling.pressure == pytest.approx(0.5 * (AMBIENT + REGULATOR), rel=2e-3)
    filling.advance(0.001 * half + FILL_TIME)
    assert filling.pressure == pytest.approx(REGULATOR - 0.5 * exp(-1.0) * (REGULATOR - AMBIENT))
    filling.advance(1.0)
    assert filling.is_steady
    assert filling.pressure == REGULATOR


def test_it_dumps() -> None:
    dumping = line(air=True)
    dumping.air = False
    dumping.advance(DUMP_TIME)
    assert dumping.pressure - AMBIENT == pytest.approx(exp(-1.0) * (REGULATOR - AMBIENT))
    dumping.advance(1.0)
    assert dumping.pressure == AMBIENT
    assert dumping.is_steady


@given(st.lists(st.tuples(st.booleans(), spans), max_size=20))
def test_it_never_leaves_what_feeds_it(phases: list[tuple[bool, float]]) -> None:
    turned = line(air=False)
    for air, seconds in phases:
        turned.air = air
        before = turned.pressure
        turned.advance(seconds)
        assert AMBIENT <= turned.pressure <= REGULATOR
        assert (turned.pressure >= before) if air else (turned.pressure <= before)


@given(st.lists(spans, min_size=1, max_size=8), st.booleans())
def test_in_however_many_pieces_time_passes(pieces: list[float], air: bool) -> None:
    whole, parted = line(air=not air), line(air=not air)
    whole.air = parted.air = air
    whole.advance(sum(pieces))
    for piece in pieces:
        parted.advance(piece)
    # Who arrives within a pascal has arrived.
    assert parted.pressure == pytest.approx(whole.pressure, abs=2.0)


def test_it_follows_a_regulator_that_changes() -> None:
    followed = line(air=True)
    followed.regulator = AMBIENT + 1.5 * (REGULATOR - AMBIENT)
    followed.advance(1.0)
    assert followed.pressure == followed.regulator
    followed.regulator = AMBIENT
    followed.advance(1.0)
    assert followed.pressure == AMBIENT
