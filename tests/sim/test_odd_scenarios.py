"""Any value in any field of a scenario gives a run that is right, or one line that says what is wrong."""

import sys
from dataclasses import fields
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from layflat.errors import LayflatError
from layflat.machine import load
from layflat.motion.scenario import SIGNALS
from layflat.sim import Scenario
from layflat.sim.run import start_angles
from layflat.sim.signals import acting_signals, start_pressures

ARM = load("paper-arm")
NAMES = [field.name for field in fields(Scenario)]

NUMBERS = (Decimal("0.1"), Fraction(1, 3), 10**400, np.float32(0.1), np.int8(1), np.bool_(True), np.nan)
TEXTS = ("20 deg", "0.1 rad", "4 bar", "1 kg", "0.5 s", "0.05 s", "2 N m", "6 V", "nan deg", "1e999 bar", "no")
SHAPES = ((), (1,), (2,), (20,), (21,), (20, 1), (20, 2), (2, 20), (20, 2, 1), (0,), (0, 2))
TYPES = ("f8", "f4", "i4", "u1", "b", "?", "c16", "U8", "O", "M8[s]", "m8[s]")


def array_of(shape: tuple[int, ...], value: float, kind: str) -> Any:
    return np.full(shape, value).astype(kind)


numbers = st.one_of(
    st.floats(), st.integers(), st.booleans(), st.complex_numbers(), st.none(), st.sampled_from(NUMBERS)
)
scalars = st.one_of(numbers, st.text(max_size=8), st.sampled_from(TEXTS), st.binary(max_size=4))
keys = st.one_of(st.sampled_from(["large", "small", "wrist", "x", "payload"]), scalars)
rows = st.one_of(scalars, st.lists(scalars, max_size=3), st.dictionaries(keys, scalars, max_size=3))
magnitudes = st.sampled_from([0.0, 0.1, 1.0, 5.0, -1.0])
arrays = st.builds(array_of, st.sampled_from(SHAPES), magnitudes, st.sampled_from(TYPES))
values = st.one_of(
    rows,
    arrays,
    st.lists(st.tuples(scalars, rows), min_size=1, max_size=3),
    st.lists(rows, max_size=3),
    st.builds(lambda value: lambda _: value, rows),
    st.sampled_from([print, len, object(), {1, 2}, iter([1.0]), range(2), float, Scenario(), ARM]),
)


@settings(max_examples=400, deadline=None)
@given(st.sampled_from(NAMES), values)
@example("demand", np.ma.masked_all(20))
@example("pressures", {"large": ("3 bar", "3 bar"), 1: None})
@example("start", np.array(["1 deg", "2 deg"]))
def test_any_value_gives_a_run_or_one_line(name: str, value: Any) -> None:
    try:
        scenario = Scenario(**{"duration": 0.1, name: value})
        acting = acting_signals(scenario, ARM, ARM.cycle)
        start = start_angles(scenario, ARM, acting.named("demand")), start_pressures(scenario, ARM)
    except LayflatError as error:
        lines = str(error).strip().split("\n")
        assert len(lines) == 1  # either is right
        return
    assert len(acting.named("demand")) == round(scenario.cycles(ARM.cycle))
    for key in SIGNALS:
        array = acting.named(key)
        assert array.dtype == np.float64
        assert np.isfinite(array).all() or (key in {"opening", "voltage"} and np.isnan(array).all())
    assert np.isfinite(start[0]).all()
    if scenario.closed_loop:
        assert np.abs(acting.named("demand")).max() <= np.radians(60.0) + 1e-9
    assert np.nanmax(np.abs(acting.named("opening")), initial=0.0) <= 1.05 + 1e-9
    assert acting.named("brake").min() >= 0.0
    assert acting.named("supply").min() >= -ARM.supply.ambient_pressure


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "value",
    [
        True,
        1j,
        b"1",
        "",
        "nan",
        float("inf"),
        object(),
        [],
        [[]],
        {},
        np.array([]),
        np.timedelta64(1, "s"),
        lambda time: sys.exit(str(time)),
    ],
)
def test_the_same_odd_values_in_every_field(name: str, value: Any) -> None:
    test_any_value_gives_a_run_or_one_line.hypothesis.inner_test(name, value)  # type: ignore[attr-defined]
