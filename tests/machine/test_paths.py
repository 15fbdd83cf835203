"""Dotted paths: every number of a machine has one, and to change one changes nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.machine import changed, load, names
from layflat.machine.change import paths, value_at

ARM = load("paper-arm")


@pytest.mark.parametrize("name", names())
def test_every_path_leads_to_a_finite_number(name: str) -> None:
    machine = load(name)
    found = paths(machine)
    assert len(found) == len(set(found)) > 50
    assert all(np.isfinite(value_at(machine, path)) for path in found)


@given(st.sampled_from(paths(ARM)), st.floats(allow_nan=False, allow_infinity=False))
def test_one_number_is_changed_and_no_other(path: str, value: float) -> None:
    other = changed(ARM, path, value)
    assert value_at(other, path) == value
    assert paths(other) == paths(ARM)
    assert [one for one in paths(ARM) if value_at(other, one) != value_at(ARM, one)] in ([path], [])
    assert changed(other, path, value_at(ARM, path)) == ARM


@given(st.sampled_from(paths(ARM)), st.sampled_from(paths(ARM)), st.floats(0.5, 2.0), st.floats(0.5, 2.0))
def test_the_order_of_changes_does_not_matter(first: str, second: str, a: float, b: float) -> None:
    if first != second:
        one = changed(changed(ARM, first, a), second, b)
        assert one == changed(changed(ARM, second, b), first, a)


@given(st.sampled_from(paths(ARM)), st.data())
def test_a_slip_of_the_pen_is_answered_with_the_path_that_was_meant(path: str, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(path) - 1))
    slipped = path[:at] + "#" + path[at + 1 :]
    with pytest.raises(InputError) as caught:
        changed(ARM, slipped, 1.0)
    assert "nearest is '" in str(caught.value)
    assert str(caught.value).startswith(f"paper-arm: {slipped}: ")
    assert "\n" not in str(caught.value)


def test_a_path_below_a_number_is_not_there() -> None:
    for path in ("arm.payload.kg", "joint.small.losses.weights.3", "joint.small.losses.weights.-1", "", "."):
        with pytest.raises(InputError):
            changed(ARM, path, 1.0)
