import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.description import units as u
from layflat.errors import InputError

ALL = [kind for kind in vars(u).values() if isinstance(kind, u.Quantity)]


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.name)
def test_every_example_parses(kind: u.Quantity) -> None:
    assert math.isfinite(kind.parse(kind.example))


@given(st.floats(-1e6, 1e6))
def test_length_round_trip(value: float) -> None:
    assert u.LENGTH.parse(f"{value!r} mm") == pytest.approx(value / 1000, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(
    ("text", "kind", "si"),
    [
        ("120 deg", u.ANGLE, 2 * math.pi / 3),
        ("4 bar", u.PRESSURE, 4e5),
        ("20 degC", u.TEMPERATURE, 293.15),
        ("1.2 dm^3/(s bar)", u.CONDUCTANCE, 1.2e-8),
        ("0.4 V/deg", u.ERROR_GAIN, 0.4 * 180 / math.pi),
        ("40 N m/deg", u.STIFFNESS, 40 * 180 / math.pi),
    ],
)
def test_si_values(text: str, kind: u.Quantity, si: float) -> None:
    assert kind.parse(text) == pytest.approx(si, rel=1e-12)


@pytest.mark.parametrize("wrong", ["4", "4 m", "inf bar", "bar bar bar", "", "import os"])
def test_wrong_text_names_where_and_what_is_right(wrong: str) -> None:
    with pytest.raises(InputError, match=r'--supply: .*give a pressure such as "4 bar"'):
        u.quantity(wrong, u.PRESSURE, "--supply")


def test_numbers_from_code_are_si() -> None:
    assert u.quantity(2.5, u.PRESSURE, "x") == 2.5
    with pytest.raises(InputError, match="not finite"):
        u.quantity(math.nan, u.PRESSURE, "x")
