"""Gains are shown in words and in the units in which people write them, and come back as they were or as typed."""

import pytest

from layflat.description.change import changed, paths, value_at
from layflat.errors import LayflatError
from layflat.machine import Machine, load
from layflat.pages.panel.controller_view import PREFIXES, _changed_value, describe_path
from layflat.pages.panel.desk import written_values
from layflat.pages.studio.field import Field, field_at

SI = {"rad", "V/rad", "V/Pa", "Pa", "m", "rad/s", "V/rad/s"}


def numbers(machine: Machine) -> list[tuple[Field, float]]:
    written = written_values(machine)
    found = [(path, value_at(machine, path)) for path in paths(machine) if any(part in path for part in PREFIXES)]
    return [(field_at(machine, written, path).readable(value), value) for path, value in found
            if isinstance(value, float)]  # fmt: skip


@pytest.mark.parametrize("name", ["paper-arm", "picking-arm", "paper-arm-tracking"])
def test_every_number_has_a_unit_that_people_write_and_stays_what_it_is(name: str) -> None:
    machine = load(name)
    assert len(numbers(machine)) > 10
    for field, value in numbers(machine):
        assert (field.unit == "") == (field.quantity is None)
        assert field.unit not in SI, field.path
        assert _changed_value(field, field.number(value), value) is None
        text = _changed_value(field, 1.01 * field.number(value) + 1e-9, value)
        if value > 0.0 and "fraction" not in field.path and "observer_gain" not in field.path:
            assert value_at(changed(machine, field.path, text), field.path) == pytest.approx(1.01 * value, rel=1e-6)


def test_names_are_words() -> None:
    assert describe_path("joint.large.gains.near_below.speed") == "Large: near below speed"
    assert describe_path("controller.drift_time") == "Drift time"


@pytest.mark.parametrize("value", [None, "", "banana", True, float("nan")])
def test_what_is_no_number_is_told_by_the_value_s_name(value: object) -> None:
    field, before = numbers(load("paper-arm"))[0]
    with pytest.raises(LayflatError, match="Large: far error: holds no number; give one"):
        _changed_value(field, value, before)
