from fractions import Fraction
from math import radians
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.motion.signal_rows import expand_signal
from layflat.motion.signal_values import Sampling, SignalKind, single_kind

NAMES = ["large", "small"]
SAMPLING = Sampling(0.005, 200)
TIMES = SAMPLING.times
DEMAND = SignalKind("demand", u.ANGLE, NAMES)


def rows(signal: Any, *, kind: SignalKind = DEMAND, before: tuple[float, ...] = (0.0, 0.0)) -> Array:
    return expand_signal(signal, kind, np.array(before), SAMPLING)


@pytest.mark.parametrize("value", ["30 deg", radians(30), np.float32(radians(30)), np.array("30 deg"), ["30 deg"] * 2])
def test_a_constant_fills_all_joints(value: object) -> None:
    assert rows(value) == pytest.approx(radians(30))


def test_numbers_may_be_of_any_real_type() -> None:
    assert np.all(rows(Fraction(1, 4)) == 0.25)
    assert np.all(rows(np.int16(1)) == 1.0)
    assert np.all(rows(np.full((200, 2), 1, dtype=np.uint8)) == 1.0)
    assert np.all(rows(np.full(200, "30 deg")) == radians(30))
    assert np.all(rows(np.full((200, 2), "30 deg", dtype=object)) == radians(30))


def test_a_joint_that_is_not_named_keeps_what_it_had() -> None:
    constant = rows({"small": "30 deg"}, before=(0.1, 0.2))
    assert np.all(constant == [0.1, radians(30)])
    steps = rows([(0.1, {"large": 0.3}), (0.5, {"small": 0.4})], before=(0.1, 0.2))
    assert np.all(steps[TIMES < 0.099] == [0.1, 0.2])
    assert np.all(steps[20:100] == [0.3, 0.2])
    assert np.all(steps[100:] == [0.3, 0.4])
    function = rows(lambda t: {"large": 0.3} if t < 0.5 else {"small": 0.4}, before=(0.1, 0.2))
    assert np.all(function[:100] == [0.3, 0.2])
    assert np.all(function[100:] == [0.3, 0.4])


@given(st.floats(0.011, 0.9))
def test_a_step_holds_from_its_time_on(at: float) -> None:
    column = rows([(0.0, 0.1), (at, 0.2)])[:, 0]
    assert np.all(column[TIMES < at - 1e-6] == 0.1)
    assert np.all(column[TIMES >= at] == 0.2)


def test_a_function_and_an_array_mean_the_same() -> None:
    assert np.array_equal(rows(lambda t: float(np.sin(t))), rows(np.sin(TIMES)))


def failing(time: float) -> float:
    return 1.0 / (time - 0.5)


@pytest.mark.parametrize(
    ("signal", "expected"),
    [
        ("40", "'40' is a bare number"),
        (True, "True is not an angle"),
        (np.True_, "is not an angle"),
        (1j, "1j is not an angle"),
        (np.complex64(1.0), "is not an angle"),
        (None, "None is not an angle"),
        (b"40 deg", "b'40 deg' is not an angle"),
        ({1, 2}, "is not an angle"),
        (10**400, "is not finite"),
        (float("nan"), "nan is not finite"),
        ({0: 0.1}, "unknown joint 0; joints are large, small"),
        ({"wrist": 0.1, 3: 0.1}, "unknown joint 'wrist'"),
        ([], "has 0 values; give 2: large, small"),
        ([[0.0, 0.1], [1.0, 0.2]], "is neither a row of values nor steps; steps are tuples"),
        ([0.1, "x"], "'x' is not one number with one unit"),
        (np.full((200, 2), 1j), "an array of complex128 holds no numbers"),
        (np.full((200, 2), True), "an array of bool holds no numbers"),
        (np.full((200, 2), "x"), "'x' is not one number with one unit"),
        (np.full((200, 2), None), "None is not an angle"),
        (np.ma.masked_greater(np.arange(200.0), 100.0), "holds masked values"),
        (np.zeros((200, 2, 1)), r"an array of shape (200, 2, 1) does not fit; give shape (200, 2): a row for each"),
        (np.zeros((2, 200)), "this one is transposed"),
        (np.zeros((201, 2)), "records have one more: leave out the last"),
        (np.zeros(2), "or a list for one value each"),
        (np.full(200, np.inf), "holds a value that is not finite"),
        ([("1 s", 0.0), ("1 s", 0.1)], "the times of its steps do not grow"),
        ([("-1 s", 0.0)], "-1 s is before the start"),
        ([("0 s", 0.0), ("1 s", 0.1)], "1 s is after the end; the run ends at 1 s: give an earlier time"),
        ([("0 s", 0.0), (0.9951, 0.1)], "0.9951 s is after the end"),
        ([(0.501, 0.0), (0.503, 0.1)], "its steps at 0.501 s and 0.503 s fall into one control cycle of 0.005 s"),
        ([("nan s", 0.0)], "'nan s' is not finite"),
        ([(True, 0.0)], "True is not a time"),
        (failing, "its function fails at 0.5 s (ZeroDivisionError: "),
        (print, "None is not an angle"),
        (lambda _: float("inf"), "inf is not finite"),
        (lambda: 0.0, "its function fails at 0 s (TypeError"),
        (lambda t: [("0 s", t)], "is neither a row of values nor steps"),
    ],
)
def test_what_is_no_signal_is_named(signal: object, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        rows(signal)
    assert str(caught.value).startswith("demand: ")
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_signal_that_joints_share_has_no_joints() -> None:
    payload = single_kind("payload", u.MASS)
    assert np.all(rows("2 kg", kind=payload, before=(1.0,)) == 2.0)
    for signal in ({"large": "2 kg"}, ["1 kg", "2 kg"]):
        with pytest.raises(InputError, match=r"payload: .*; give one value: payload is the same for all joints"):
            rows(signal, kind=payload, before=(1.0,))


@pytest.mark.parametrize("period", [0.0003, 0.0025, 0.0036, 0.005, 0.0066, 0.0095])
def test_a_function_that_is_too_fast_for_the_cycles_is_refused(period: float) -> None:
    for function in (np.sin, lambda x: np.sign(np.sin(x + 0.3))):
        with pytest.raises(InputError, match="demand: changes faster than control cycles of 5 ms can follow"):
            rows(lambda t, f=function: float(f(2.0 * np.pi * t / period)))


@pytest.mark.parametrize("period", [0.0003, 0.0025, 0.005, 0.0066, 0.0095])
def test_a_ripple_on_a_slow_motion_is_not_lost(period: float) -> None:
    with pytest.raises(InputError, match="demand: changes faster than control cycles"):
        rows(lambda t: 0.3 * t + 0.01 * float(np.sin(2.0 * np.pi * t / period)))


@pytest.mark.parametrize("period", [0.011, 0.0151, 0.02, 0.1, 1.7, 30.0])
@pytest.mark.parametrize("shift", [0.0, 0.7, 1.5])
def test_a_function_that_the_cycles_can_follow_is_taken(period: float, shift: float) -> None:
    for function in (np.sin, lambda x: np.sign(np.sin(x)), lambda x: np.sin(x) + 3.0 * x, lambda x: float(x > 1.0)):
        rows(lambda t, f=function: float(f(2.0 * np.pi * t / period + shift)))
