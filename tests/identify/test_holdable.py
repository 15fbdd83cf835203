"""Values of any size become texts that a description takes."""

from __future__ import annotations

from math import inf
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.description import Part
from layflat.description.change import annotation_at, changed_all, paths, quantity_of, value_at
from layflat.errors import InputError
from layflat.identify.benches.loader import build_bench, description_tables, load_bench, load_description
from layflat.identify.identified_file import format_value, format_values, holds_other_value
from layflat.machine.listing import nested_value
from layflat.machine.loader import BENCH_LIBRARY

MACHINES = ("paper-small-joint", "picking-arm")
NEAR = 1e-6  # rounding of a text with seven digits
ODD = (0.0, -0.0, 5e-324, -5e-324, 1e-300, 5.99e-10, -5.99e-10, 1e-9, 1.0, -1.0, 1e6, -1e6, 1e300, -1e300)


def settable(described: Part) -> list[str]:
    """Paths of real numbers with a unit."""
    every = [path for path in paths(described) if isinstance(value_at(described, path), float)]
    return [path for path in every if quantity_of(annotation_at(described, path)) is not None]


def read_back(described: Part, path: str, value: float, before: Any) -> float:
    text = format_value(described, path, value, before)
    return float(value_at(changed_all(described, {path: text}, together=False), path))


@pytest.mark.parametrize("name", [*BENCH_LIBRARY.names, *MACHINES])
@pytest.mark.parametrize("odd", ODD)
def test_any_value_of_any_key_is_written_so_that_it_loads(name: str, odd: float) -> None:
    described, plain = load_description(name), description_tables(name)[0]
    for path in settable(described):
        kept = read_back(described, path, odd, nested_value(plain, path.split(".")))
        quantity = quantity_of(annotation_at(described, path))
        assert quantity is not None
        assert kept == 0.0 or quantity.least * (1.0 - NEAR) <= abs(kept) <= quantity.most * (1.0 + NEAR), path


@settings(max_examples=60, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_value_that_may_stand_there_is_kept(value: float) -> None:
    rig, path = load_bench("friction-rig"), "piston.offset"
    kept = read_back(rig, path, value, "0 N")
    quantity = quantity_of(annotation_at(rig, path))
    assert quantity is not None
    if 1.000001 * quantity.least <= abs(value) <= 0.999999 * quantity.most:
        assert kept == pytest.approx(value, rel=1e-6)
    else:
        assert abs(kept) <= 1.000001 * quantity.least or abs(kept) >= 0.999 * quantity.most


def test_a_length_below_what_makes_sense_is_zero_where_zero_may_stand_and_else_the_least() -> None:
    rig = load_bench("friction-rig")
    texts = format_values(
        rig,
        {"friction.profile_from": 5.99e-10, "friction.deflections.0": 5.99e-10, "piston.offset": -0.0},
        {"friction.profile_from": "0 mm", "friction.deflections.0": "0.05 mm", "piston.offset": "0 N"},
    )
    assert texts == {"friction.profile_from": "0 mm", "friction.deflections.0": "1e-06 mm", "piston.offset": "0 N"}
    assert holds_other_value(rig, "friction.deflections.0", texts["friction.deflections.0"], 5.99e-10)
    assert not holds_other_value(rig, "piston.offset", texts["piston.offset"], 0.0)


def test_a_bound_of_another_value_that_rounds_beyond_it_is_written_with_all_digits() -> None:
    """A stop at the end of a reading of 119.999987 deg, in seven digits, lies inside the reading."""
    plain = description_tables("regulated-elbow")[0]
    plain["stroke"] |= {"reading": "119.999987 deg"}
    rig = build_bench(plain, "test")
    stop = -0.5 * rig.stroke.reading
    texts = format_values(rig, {"stroke.lower_stop": stop}, {"stroke.lower_stop": "-60 deg"})
    assert changed_all(rig, texts).stroke.lower_stop == pytest.approx(stop, rel=1e-12)


def test_values_that_contradict_each_other_are_refused() -> None:
    rig = load_bench("regulated-elbow")
    with pytest.raises(InputError, match="stops lie inside"):
        format_values(rig, {"stroke.lower_stop": -0.5}, {"stroke.lower_stop": "-60 deg"})
    with pytest.raises(InputError):
        format_values(rig, {"load.inertia": inf}, {})
