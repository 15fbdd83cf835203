"""Deep groove ball bearings of thin series."""

from itertools import pairwise
from math import pi

import pytest

from layflat.design.cam import BORE_DIAMETERS
from layflat.errors import DesignError
from layflat.solids.standard.bearings import BEARINGS, Bearing, bearing


def test_every_common_bore_has_its_bearing() -> None:
    assert [bearing(bore).bore for bore in BORE_DIAMETERS] == pytest.approx(BORE_DIAMETERS)


def test_sizes_and_ratings_grow_within_a_series() -> None:
    for smaller, larger in pairwise(BEARINGS):
        assert smaller.bore < larger.bore
        assert smaller.outer <= larger.outer
        if smaller.number.startswith("618") and larger.number.startswith("618"):
            assert smaller.static_load < larger.static_load
            assert smaller.mass < larger.mass


@pytest.mark.parametrize("entry", BEARINGS, ids=lambda entry: entry.number)
def test_a_bearing_fills_about_two_thirds_of_its_ring(entry: Bearing) -> None:
    ring = pi / 4 * (entry.outer**2 - entry.bore**2) * entry.width
    assert 0.62 < entry.mass / (7810 * ring) < 0.76


@pytest.mark.parametrize("entry", BEARINGS, ids=lambda entry: entry.number)
def test_the_number_holds_the_bore(entry: Bearing) -> None:
    number, bore = entry.number, round(entry.bore * 1e3)
    code = {10: 0, 12: 1, 15: 2, 17: 3}.get(bore, bore // 5)  # ISO 15: 00 to 03, then a fifth of the bore
    assert number == (f"619/{bore}" if bore < 10 else f"618{code:02d}")


def test_a_61805_is_the_one_of_the_catalogues() -> None:
    chosen = bearing(0.025)
    assert chosen.designation == "61805-2RS"
    assert (chosen.outer, chosen.width) == pytest.approx((0.037, 0.007))
    assert chosen.static_load == 2600.0


def test_a_bore_without_bearing_lists_those_with_one() -> None:
    with pytest.raises(DesignError, match=r"no bearing has a bore of 11 mm; bores are 4, 5, .*, 50, 60 mm"):
        bearing(0.011)
