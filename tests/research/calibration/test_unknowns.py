import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.description.change import changed_all, value_at
from layflat.machine import load
from layflat.machine.exchanged import with_losses
from research.calibration import unknowns as u

ALL = (*u.gains("small"), *u.gains("large"), *u.AIR, *u.LOSSES["elasto-slip"], u.DAMPING)
MIDDLE = np.full(len(ALL), 0.4)


def test_shares_round_trip_through_values() -> None:
    values = u.to_values(ALL, MIDDLE)
    assert u.to_shares(ALL, values) == pytest.approx(MIDDLE)
    low, high = u.to_values(ALL, np.zeros(len(ALL))), u.to_values(ALL, np.ones(len(ALL)))
    assert low == pytest.approx([one.low for one in ALL])
    assert high == pytest.approx([one.high for one in ALL])


@given(st.sampled_from(sorted(u.LOSSES)), st.floats(0.0, 1.0))
def test_places_in_a_range_are_counted_in_factors_or_where_it_has_zero_in_differences(kind: str, place: float) -> None:
    shares = np.full(len(u.LOSSES[kind]), place)
    values = u.to_values(u.LOSSES[kind], shares)
    assert u.to_shares(u.LOSSES[kind], values) == pytest.approx(shares, abs=1e-12)
    for one, value in zip(u.LOSSES[kind], values, strict=True):
        even = one.low + place * (one.high - one.low) if one.low <= 0.0 else one.low * (one.high / one.low) ** place
        assert value == pytest.approx(even)


def test_values_round_trip_through_a_machine_and_its_text() -> None:
    values = u.to_values(ALL, MIDDLE)
    machine = changed_all(load("paper-arm"), u.as_text(ALL, values))
    assert u.values_of(machine, ALL) == pytest.approx(values, rel=0.02)
    many = u.by_path(ALL, values[None])
    assert all(len(column) == 1 for column in many.values())
    gain = "joint.small.gains.close.error"
    assert many[gain][0] == pytest.approx(value_at(machine, gain), rel=5e-3)


def test_gains_change_from_phase_to_phase_as_the_paper_says() -> None:
    rng = np.random.default_rng(1)
    found = u.by_path(ALL, u.to_values(ALL, rng.random((50, len(ALL)))))
    for joint in u.JOINT_NAMES:
        errors, pressures = (
            np.array([found[f"joint.{joint}.gains.{phase}.{what}"] for phase in ("far", "near", "close")])
            for what in ("error", "pressure")
        )
        assert (np.diff(errors, axis=0) >= 0.0).all()
        assert (np.diff(pressures, axis=0) <= 0.0).all()


def test_weights_of_elements_add_up() -> None:
    text = u.as_text(ALL, u.to_values(ALL, MIDDLE))
    assert sum(text["joint.small.losses.weights"]) == pytest.approx(1.0, abs=1e-9)
    many = u.by_path(ALL, u.to_values(ALL, np.tile(MIDDLE, (3, 1))))
    assert sum(many[f"joint.large.losses.weights.{i}"] for i in range(3)) == pytest.approx(np.ones(3))


def test_joints_that_a_machine_has_not_are_passed_over() -> None:
    earlier = load("earlier-actuator")
    earlier = earlier.model_copy(update={"joint": {"small": earlier.joint["small"]}})
    known = u.values_in(earlier, u.by_path(ALL, u.to_values(ALL, MIDDLE)))
    assert not any(".large." in path for path in known)
    assert "valve.conductance" in known


@pytest.mark.parametrize("kind", u.LOSSES)
def test_what_is_open_of_a_kind_stands_in_its_description(kind: str) -> None:
    machine = with_losses(load("paper-arm"), kind, u.STARTS[kind])
    sought = (*u.LOSSES[kind], u.DAMPING)
    changed = changed_all(machine, u.as_text(sought, u.to_values(sought, np.full(len(sought), 0.3))))
    assert {joint.losses.kind for joint in changed.joint.values()} == {kind}
    assert changed.joint["small"].losses == changed.joint["large"].losses
