import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.description import units as u
from layflat.description.expression import split_quantity, unit_of
from layflat.description.factors import CELSIUS, DERIVED_UNITS, PREFIXED_UNITS, PREFIXES
from layflat.errors import InputError

ALL = u.QUANTITIES


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.name)
def test_every_example_parses(kind: u.Quantity) -> None:
    assert math.isfinite(kind.parse(kind.example))


@given(st.floats(-1e6, 1e6))
def test_length_round_trip(value: float) -> None:
    assert u.LENGTH.convert(f"{value!r} mm") == pytest.approx(value / 1000, rel=1e-12, abs=1e-15)


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


@pytest.mark.parametrize(
    "wrong", ["4", "4 m", "inf bar", "nan bar", "bar bar", "", "import os", "4 bar x", "1.2.3 bar"]
)
def test_wrong_text_names_where_and_what_is_right(wrong: str) -> None:
    with pytest.raises(InputError, match=r'--supply: .*give a pressure such as "4 bar"'):
        u.quantity(wrong, u.PRESSURE, "--supply")


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("2,5 kg", u.MASS, """has a comma in its number; write "2.5 kg\""""),
        ("1,000 kg", u.MASS, """write "1.000 kg", or "1000 kg" if it stands between thousands"""),
        ("5 bara", u.PRESSURE, """is an absolute pressure; write "5 bar" only if that is meant here"""),
        ("5 bar (abs)", u.PRESSURE, "is an absolute pressure"),
        ("60 psia", u.PRESSURE, "is an absolute pressure"),
        ("5 bar a", u.PRESSURE, "is an absolute pressure"),
        ("60 psig", u.PRESSURE, """is a gauge pressure; write "60 psi" only if that is meant here"""),
        ("4 barg", u.PRESSURE, "is a gauge pressure"),
        ("400 kPa(g)", u.PRESSURE, "is a gauge pressure"),
        ("2*3 kg", u.MASS, "is not one number with one unit"),
        ("2+3 kg", u.MASS, "is not one number with one unit"),
        ("2 3 kg", u.MASS, "is not one number with one unit"),
        ("9**9**9**9 kg", u.MASS, "has an exponent without a unit"),
        ("1 bar**9**9**9", u.PRESSURE, "has an exponent without a unit"),
        ("1 bar^99", u.PRESSURE, "has an exponent of 99; write one from -9 to 9"),
        ("1 dm^3/(s bar", u.CONDUCTANCE, "has a bracket that does not close"),
        ("1 dm^3/s bar)", u.CONDUCTANCE, "has a ')' too many in its unit"),
        ("1 N*/m", u.SPRING_RATE, "has two signs side by side in its unit"),
        ("1 N/", u.FORCE, "has a unit that is not complete"),
        ("1 W/degC", u.HEAT_CONDUCTANCE, "has degC in a product; write K, which is the same for differences"),
        ("25 Nm", u.TORQUE, 'did you mean "25 N m"?'),
        ("4 Bar", u.PRESSURE, 'did you mean "4 bar"?'),
        ("4 mpa", u.PRESSURE, """; did you mean "4 MPa\"?"""),
        ("3 Kg", u.MASS, 'did you mean "3 kg"?'),
        ("0.2 Nm/deg", u.STIFFNESS, 'did you mean "0.2 N m/deg"?'),
        ("3 pears", u.LENGTH, 'is not a number with a unit of length; give a length such as "160 mm"'),
        ("10 Hz", u.ANGULAR_SPEED, "is not an angular speed"),
        ("10 rad/s", u.FREQUENCY, "is not a frequency"),
        ("50 %", u.ANGLE, "is not an angle"),
        ("1e200 m", u.LENGTH, "is out of range; give a length between 1e-09 and 100 m"),
        ("1e-200 m", u.LENGTH, "is out of range"),
        ("1e9 bar", u.PRESSURE, "is out of range"),
        ("1000 deg", u.ANGLE, "is out of range"),
        ("(" * 50 + "m", u.LENGTH, "is not one number with one unit"),
        ("1 " + "(" * 50 + "m", u.LENGTH, "has a bracket that does not close"),
        ("1 " + "m" * 1000, u.LENGTH, "is too long for a quantity"),
    ],
)
def test_one_number_and_one_unit_or_what_is_wrong(text: str, kind: u.Quantity, said: str) -> None:
    with pytest.raises(InputError) as caught:
        u.quantity(text, kind, "here")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "25 N m",
        "25N m",
        " 25  N*m ",
        "25 N·m",
        "+25 N m",
        "25.0e0 m N",
        "25000 mN m",
        "25 J",
        "25 kg m²/s²",
        "25 kg*m**2/s^2",
    ],
)
def test_ways_to_write_the_same(text: str) -> None:
    assert u.TORQUE.parse(text) == pytest.approx(25.0, rel=1e-12)


@pytest.mark.parametrize("text", ["50 1/s", "50 s^-1", "50 s**(-1)", "50 s⁻¹", "0.05 1/ms"])
def test_units_below_the_line(text: str) -> None:
    assert u.FREQUENCY.parse(text) == pytest.approx(50.0, rel=1e-12)


@given(st.text("0123456789.,+-*/^()eE degCmNbark²%", max_size=30))
def test_any_text_is_a_quantity_or_told(text: str) -> None:
    try:
        assert math.isfinite(u.quantity(text, u.LENGTH, "here"))
    except InputError as error:
        told = error
    else:
        return
    assert told.what.startswith(repr(text)[:20])
    assert told.right


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.name)
def test_every_kind_has_a_range_that_makes_sense(kind: u.Quantity) -> None:
    value = kind.parse(kind.example)
    assert 0.0 < kind.least < value < kind.most < 1e15
    for number in (2.0 * kind.most, -2.0 * kind.most, 0.5 * kind.least):
        with pytest.raises(u.QuantityError, match="is out of range"):
            kind.check_range(number)


def test_numbers_from_code_are_si() -> None:
    assert u.quantity(2.5, u.PRESSURE, "x") == 2.5
    with pytest.raises(InputError, match="not finite"):
        u.quantity(math.nan, u.PRESSURE, "x")


def test_numbers_from_code_may_be_of_any_magnitude() -> None:
    assert u.quantity(1e12, u.TORQUE, "x") == 1e12
    assert u.quantity(8.5e-17, u.ANGLE, "x") == 8.5e-17  # zero but for rounding


WRITTEN_IN = [
    (kind, unit)
    for kind in u.QUANTITIES
    for unit in dict.fromkeys(
        [
            kind.unit,
            split_quantity(kind.example)[1],
            *(p + b for p in ("", *PREFIXES) for b in PREFIXED_UNITS),
            *DERIVED_UNITS,
            CELSIUS,
        ]
    )
    if "π" not in unit and kind._measures(dict(unit_of(unit)))
]


@given(st.sampled_from(WRITTEN_IN), st.floats(-25.0, 15.0), st.sampled_from([1.0, -1.0, 0.0]))
@settings(max_examples=2000)
def test_what_is_written_is_read_back(chosen: tuple[u.Quantity, str], exponent: float, sign: float) -> None:
    kind, unit = chosen
    value = sign * 10.0**exponent
    value = min(max(value, -kind.most), kind.most)
    read = kind.parse(kind.text(value, unit))
    if abs(value) < kind.least:
        value = 0.0
    # A temperature in degC has its digits beside the zero of that scale.
    assert read == pytest.approx(value, rel=1e-6, abs=1e-6 * 273.15 if unit == CELSIUS else 0.0)


@pytest.mark.parametrize("kind", u.QUANTITIES, ids=lambda kind: kind.name)
def test_the_ends_of_a_range_are_read_back(kind: u.Quantity) -> None:
    for end in (kind.least, kind.most):
        for unit in [unit for one, unit in WRITTEN_IN if one == kind and unit != CELSIUS]:
            assert kind.parse(kind.text(end, unit)) == pytest.approx(end, rel=1e-6)
