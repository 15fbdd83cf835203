"""Dotted paths: every number of a machine has one, and to change one changes nothing else."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from layflat.description.change import paths, value_at
from layflat.errors import InputError
from layflat.machine import Machine, changed, load, names

ARM = load("paper-arm")


@pytest.mark.parametrize("name", names())
def test_every_path_leads_to_a_finite_number(name: str) -> None:
    machine = load(name)
    found = paths(machine)
    assert len(found) == len(set(found)) > 50
    assert all(np.isfinite(value_at(machine, path)) for path in found)


def scaled(path: str, factor: float) -> Machine | None:
    """The arm with one number a little larger or smaller; None where that number may not be so."""
    with suppress(InputError):
        return changed(ARM, path, factor * value_at(ARM, path))
    return None


@given(st.sampled_from(paths(ARM)), st.floats(0.97, 1.03))
def test_one_number_is_changed_and_no_other(path: str, factor: float) -> None:
    other = scaled(path, factor)
    assume(other is not None)
    assert other is not None
    assert value_at(other, path) == factor * value_at(ARM, path)
    assert paths(other) == paths(ARM)
    assert [one for one in paths(ARM) if value_at(other, one) != value_at(ARM, one)] in ([path], [])
    assert changed(other, path, value_at(ARM, path)) == ARM


@given(st.sampled_from(paths(ARM)), st.sampled_from(paths(ARM)))
def test_the_order_of_changes_does_not_matter(first: str, second: str) -> None:
    one, other = scaled(first, 1.01), scaled(second, 0.99)
    assume(first != second and one is not None and other is not None)
    assert one is not None
    assert other is not None
    assert changed(one, second, value_at(other, second)) == changed(other, first, value_at(one, first))


def test_nearly_every_number_may_be_a_little_other_than_it_is() -> None:
    refused = {path for path in paths(ARM) if scaled(path, 1.01) is None}
    assert {"joint.small.losses.weights.0", "joint.small.strap.layers"} <= refused
    assert len(refused) < 0.15 * len(paths(ARM))


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


def test_a_number_may_be_zero_but_for_rounding_where_zero_may_stand() -> None:
    assert value_at(changed(ARM, "valve.delay", 1.6e-24), "valve.delay") == 1.6e-24
    many = value_at(changed(ARM, "valve.delay", np.array([1.6e-24, 0.0, 2e-3])), "valve.delay")
    assert many.tolist() == [1.6e-24, 0.0, 2e-3]
    with pytest.raises(InputError, match="out of range"):
        changed(ARM, "joint.small.hose.width", 1.6e-24)
