"""Stock of plates, bars, tubes and shafts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import DesignError
from layflat.solids.standard.stock import PLATE_THICKNESSES, next_thickness, next_tube


@given(st.floats(1e-5, PLATE_THICKNESSES[-1]))
def test_the_next_plate_is_the_thinnest_that_suffices(minimum: float) -> None:
    thickness = next_thickness(minimum)
    assert thickness >= minimum - 1e-6
    assert all(t < minimum for t in PLATE_THICKNESSES if t < thickness)


def test_a_size_in_stock_is_itself() -> None:
    assert [next_thickness(t) for t in PLATE_THICKNESSES] == list(PLATE_THICKNESSES)


@given(st.floats(0.01, 0.3), st.floats(1e-4, 3e-3))
def test_a_tube_is_as_wide_and_thick_as_demanded_and_hollow(outer: float, wall: float) -> None:
    tube = next_tube(outer, wall)
    assert tube.outer >= outer - 1e-6
    assert tube.wall >= wall - 1e-6
    assert 0 < tube.inner < tube.outer


def test_sizes_out_of_stock_are_refused() -> None:
    with pytest.raises(DesignError, match="plate: 31 mm are needed; the largest in stock is 30 mm"):
        next_thickness(0.031)
    with pytest.raises(DesignError, match="a wall of 6 mm leaves no bore in 12 mm; a thinner wall"):
        next_tube(0.012, 0.006)
