from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from layflat.description import units as u
from layflat.description.change import annotation_at, changed_all, paths, quantity_of, value_at
from layflat.description.tables import overlay
from layflat.errors import InputError
from layflat.identify.benches.loader import load_bench
from layflat.machine import build, changed, load
from layflat.machine.loader import tables

ARM = load("paper-arm")


def test_one_value_is_replaced_and_the_rest_stays() -> None:
    other = changed(ARM, "joint.small.losses.deflections.0", 0.5)
    assert other.joint["small"].losses.deflections[0] == 0.5
    assert changed(other, "joint.small.losses.deflections.0", ARM.joint["small"].losses.deflections[0]) == ARM


def test_a_key_of_a_table_that_was_left_out_makes_the_table() -> None:
    assert ARM.joint["small"].build is None
    other = changed_all(ARM, {"joint.small.build.clearance": "2 mm", "joint.small.build.screw": "M6"})
    plain, sources = tables("paper-arm")
    in_file = overlay(plain, {"joint": {"small": {"build": {"clearance": "2 mm", "screw": "M6"}}}})
    assert other == build(in_file, sources, "mine.toml")
    assert other.provenance["joint.small.build.clearance"].source == "given"
    with pytest.raises(
        InputError, match=r"joint\.small\.build\.clearnce: 'clearnce' is not there; nearest is 'joint\.small"
    ):
        changed(ARM, "joint.small.build.clearnce", "2 mm")


@pytest.mark.parametrize("path", ["joint.wrist.brake.torque", "joint.small.brake.torqe", "arm.joints.7", "nothing"])
def test_a_path_that_is_not_there(path: str) -> None:
    with pytest.raises(InputError, match="is not there"):
        changed(ARM, path, 1.0)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("arm.payload", -50, "arm.payload: -50 is out of range; give at least 0"),
        ("arm.payload", "3 m", "arm.payload: '3 m' is not a mass"),
        ("arm.payload", "2,5 kg", 'has a comma in its number; write "2.5 kg"'),
        ("arm.payload", 1e6, "arm.payload: 1000000.0 is out of range; give a mass between"),
        ("arm.payload", float("nan"), "arm.payload: nan is not finite"),
        ("arm.payload", True, "arm.payload: True is not a mass"),
        ("arm.payload", None, "arm.payload: None is not a mass"),
        ("arm.payload", [1.0], "arm.payload: [1.0] is not a mass"),
        ("arm.payload", np.array([1.0, -1.0]), "arm.payload: -1.0 is out of range; give at least 0"),
        ("arm.payload", np.array([1.0, np.nan]), "arm.payload: nan is not finite"),
        (
            "supply.temperature",
            np.array([290.0, 1e-300]),
            "supply.temperature: 0.0 is out of range; give more than 150 K",
        ),
        ("arm.payload", np.array(["1 kg"]), "is not an array of numbers"),
        ("angle_sensor.bits", -3, "angle_sensor.bits: -3 is out of range; give at least 4"),
        ("angle_sensor.bits", 9.5, "angle_sensor.bits: 9.5 is not a whole number"),
        ("angle_sensor.bits", np.array([8.0, 9.5]), "angle_sensor.bits: 9.5 is not a whole number"),
        ("valve.critical_ratio", 1.5, "valve.critical_ratio: 1.5 is out of range"),
        ("joint.small.output.kind", "square", "joint.small.output.kind: 'square' is not known; give 'roller' or 'cam'"),
        ("joint.small.gains", 3, "joint.small.gains: 3 is not a table"),
        ("joint.small.losses.weights", (0.5, 0.5, 0.5), "joint.small.losses: weights must add up to 1"),
        ("joint.small.losses.weights", (0.5, 0.5), "has 2 weights; give as many as deflections, "),
        ("joint.small.hose.contact_end", "125 deg", "joint.small.hose: contact_end must be smaller than wrap"),
        (
            "joint.small.hose.contact_end",
            np.array([1.0, 2.2]),
            "joint.small.hose: contact_end must be smaller than wrap",
        ),
        ("joint.small.hose.width", 0.01, "joint.small: hose.width is too small"),
        ("valve.delay", np.array([0.0, 1.0]), "paper-arm: valve.delay is longer than three control cycles"),
        ("arm.joints", ("large", "large"), "arm: joints names 'large' twice"),
    ],
)
def test_what_is_changed_passes_the_checks_of_a_file(path: str, value: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        changed(ARM, path, value)
    assert said in str(caught.value)
    assert str(caught.value).startswith("paper-arm: ")


def test_values_of_every_sort_are_taken() -> None:
    assert changed(ARM, "arm.payload", "3 kg").arm.payload == 3.0
    assert changed(ARM, "arm.payload", np.float64(3)).arm.payload == 3.0
    assert (
        changed(ARM, "angle_sensor.bits", np.int64(10)).angle_sensor
        == changed(ARM, "angle_sensor.bits", 10.0).angle_sensor
    )
    assert changed(ARM, "valve", None).valve is None
    gains = ARM.joint["large"].gains
    assert changed(ARM, "joint.small.gains", gains).joint["small"].gains is gains
    weights = changed(ARM, "joint.small.losses.weights", np.array([0.5, 0.25, 0.25])).joint["small"].losses.weights
    assert weights == (0.5, 0.25, 0.25)


def test_an_array_has_a_number_for_each_run() -> None:
    payloads = np.array([0.0, 1.0, 2.0])
    many = changed(ARM, "arm.payload", payloads)
    assert np.array_equal(many.arm.payload, payloads)
    thirds = tuple(np.array([0.2, 0.5]) for _ in range(2))
    rest = (1.0 - thirds[0] - thirds[1],)
    shared = changed(ARM, "joint.small.losses.weights", (*thirds, *rest)).joint["small"].losses.weights
    assert str(type(shared[0])) == "<class 'numpy.ndarray'>"
    with pytest.raises(InputError, match="weights must add up to 1"):
        changed(ARM, "joint.small.losses.weights", (*thirds, np.array([0.6, 0.1])))


def test_what_is_right_only_together_is_changed_together() -> None:
    values = {"joint.small.hose.contact_end": "125 deg", "joint.small.hose.wrap": "150 deg"}
    assert changed_all(ARM, values).joint["small"].hose.wrap == pytest.approx(2.618, rel=1e-3)
    with pytest.raises(InputError, match="contact_end must be smaller"):
        changed_all(ARM, dict(list(values.items())[:1]))


def test_a_number_that_may_be_left_out_has_its_quantity() -> None:
    plain = ARM.model_dump(mode="json")
    plain["joint"]["small"]["build"] = {"shaft_diameter": "10 mm"}
    built, path = build(plain, {}, "x"), "joint.small.build.shaft_diameter"
    assert path in paths(built)
    assert quantity_of(annotation_at(built, path)) is u.LENGTH
    assert value_at(changed(built, path, "12 mm"), path) == 0.012


@given(st.sampled_from(paths(ARM)), st.floats(allow_nan=True))
@settings(max_examples=200, deadline=None)
def test_a_number_is_taken_where_a_file_would_take_it(path: str, value: float) -> None:
    quantity = quantity_of(annotation_at(ARM, path))
    assume(quantity is None or not 0.0 < abs(value) < quantity.least)  # zero but for rounding, which no file has
    plain = ARM.model_dump(mode="json")
    table: Any = plain
    *above, last = path.split(".")
    for key in above:
        table = table[int(key)] if isinstance(table, list) else table[key]
    table[int(last) if isinstance(table, list) else last] = f"{value!r} {quantity.unit}" if quantity else value
    try:
        expected = value_at(build(plain, {}, "x"), path)
    except InputError:
        with pytest.raises(InputError):
            changed(ARM, path, value)
    else:
        assert value_at(changed(ARM, path, value), path) == expected


def test_a_bench_is_changed_alike() -> None:
    rig = load_bench("friction-rig")
    assert changed(rig, "friction.base", "3 N").friction.base == 3.0
    with pytest.raises(InputError, match=r"friction-rig: piston\.area: '3 m' is not an area"):
        changed(rig, "piston.area", "3 m")


@pytest.mark.parametrize("odd", [None, 1, 1j, b"x", [], {}, object(), ("arm", "payload")])
def test_what_is_no_path_or_no_description_is_one_line(odd: Any) -> None:
    with pytest.raises(InputError, match="is no path"):
        changed(load("paper-arm"), odd, 1.0)
    with pytest.raises(InputError, match="is no description"):
        changed(odd, "arm.payload", 1.0)
    with pytest.raises(InputError, match=r"arm\.payload"):
        changed(load("paper-arm"), "arm.payload", 10**400)
