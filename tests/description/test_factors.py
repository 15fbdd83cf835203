"""Conversions by our own table against those by Pint, bit by bit."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import layflat
from layflat.description import units as u
from layflat.description.expression import unit_of
from layflat.description.factors import DERIVED_UNITS, PREFIXED_UNITS, PREFIXES, definition, factor, is_own

KINDS = [kind for kind in vars(u).values() if isinstance(kind, u.Quantity)]
KINDS_OF = {kind.unit: kind for kind in KINDS}
FLOATS = st.floats(-1e9, 1e9) | st.integers(-(10**6), 10**6)


def built_in_texts() -> set[str]:
    """Every text in a built-in file that has a number and a unit."""
    found: set[str] = set()

    def collect(value: Any) -> None:
        if isinstance(value, dict):
            for key, item in value.items():
                if key not in {"note", "title", "source", "name"}:
                    collect(item)
        elif isinstance(value, list):
            for item in value:
                collect(item)
        elif isinstance(value, str) and re.match(r"[-+\d.]+\S* \S", value):
            found.add(value)

    for path in Path(layflat.__file__).parent.rglob("builtin/**/*.toml"):
        collect(tomllib.loads(path.read_text(encoding="utf-8")))
    return found


BUILT_IN = sorted(built_in_texts())
UNITS = sorted({text.partition(" ")[2] for text in BUILT_IN})


@cache
def by() -> pint.UnitRegistry[float]:
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True, cache_folder=None)


def by_pint(text: str, unit: str) -> float:
    # Pint remembers factors by units in any order, and takes the bits of whoever asked first.
    by()._cache.root_units.clear()
    by()._cache.conversion_factor.clear()
    return float(by().Quantity(text).to(unit).magnitude)


def kind_of(unit: str) -> u.Quantity:
    for kind in KINDS:
        if kind.example.partition(" ")[2] == unit:
            return kind
    for kind in KINDS:
        try:
            kind.convert(f"1 {unit}")
        except u.QuantityError:
            continue
        return kind
    raise AssertionError(unit)


def test_there_are_built_in_texts() -> None:
    assert len(BUILT_IN) > 300
    assert {"mm", "dm^3/(s bar)", "V/(deg s)", "degC", "kg m^2"} <= set(UNITS)


@pytest.mark.parametrize("text", BUILT_IN)
def test_what_is_built_in_is_converted_as_by_pint(text: str) -> None:
    kind = kind_of(text.partition(" ")[2])
    assert kind.convert(text) == by_pint(text, kind.unit)


@given(st.sampled_from(UNITS), FLOATS)
@settings(max_examples=400, deadline=None)
def test_any_number_is_converted_as_by_pint(unit: str, number: float) -> None:
    kind = kind_of(unit)
    assert kind.convert(f"{number!r} {unit}") == by_pint(f"{number!r} {unit}", kind.unit)


NAMES = [prefix + name for name in PREFIXED_UNITS for prefix in ("", *PREFIXES)] + [*DERIVED_UNITS.keys() - {"π", "%"}]


@st.deferred
def pairs() -> st.SearchStrategy[tuple[str, str]]:
    return st.sampled_from([(a, b) for a in NAMES for b in NAMES if a < b and by().is_compatible_with(f"1 {a}", b)])


@given(st.lists(st.tuples(pairs, st.sampled_from([-3, -2, -1, 1, 2, 3])), min_size=1, max_size=4), FLOATS)
@settings(max_examples=300, deadline=None)
def test_products_of_any_usual_units_are_converted_as_by_pint(
    parts: list[tuple[tuple[str, str], int]], number: float
) -> None:
    source = "*".join(f"{a}**{power}" for (a, _), power in parts)
    target = "*".join(f"{b}**{power}" for (_, b), power in parts)
    ours = dict(unit_of(source)), dict(unit_of(target))
    assert all(map(is_own, ours))
    if ours[0] != ours[1] and ours[0] and ours[1]:
        assert number * factor(*ours) == by_pint(f"{number!r} {source}", target)


@pytest.mark.parametrize("name", sorted(set(NAMES)))
def test_every_name_of_the_table_is_pints(name: str) -> None:
    known = definition(name)
    theirs: Any = by()._units[by().get_name(name)]
    assert theirs.is_base == (known is None)
    if known is not None:
        assert known[0] == theirs.converter.scale
        assert {by().get_name(one): n for one, n in known[1].items()} == {
            by().get_name(one): n for one, n in (theirs.reference or {}).items()
        }


@given(st.floats(1e-6, 1e6), st.sampled_from(UNITS))
def test_a_value_is_written_in_any_unit_and_read_again(value: float, unit: str) -> None:
    kind = kind_of(unit)
    value = max(value, kind.least)  # what is less is written as zero
    assert kind.convert(kind.text(value, unit)) == pytest.approx(value, rel=2e-6, abs=1e-3 if unit == "degC" else 0.0)


@pytest.mark.parametrize(
    ("text", "kind", "si"),
    [
        ("1 inch", u.LENGTH, 0.0254),
        ("14.5 psi", u.PRESSURE, 14.5 * 6894.757),
        ("2 meters", u.LENGTH, 2.0),
        ("68 degF", u.TEMPERATURE, 293.15),
        ("1 lbf inch", u.TORQUE, 0.1129848),
        ("60 rpm", u.ANGULAR_SPEED, 6.283185),
        ("0.5 turn", u.ANGLE, 3.1415927),
    ],
)
def test_other_units_are_looked_up_in_pint(text: str, kind: u.Quantity, si: float) -> None:
    assert kind.parse(text) == pytest.approx(si, rel=1e-6)


def test_usual_units_are_read_without_pint_or_the_compiler() -> None:
    code = (
        "import sys; from layflat.description import units as u; u.CONDUCTANCE.parse('1.2 dm^3/(s bar)'); "
        "u.TEMPERATURE.parse('20 degC'); print([m for m in ('pint', 'numba', 'numpy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
