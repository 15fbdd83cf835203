"""Linear models against the plant that they stand for, and what is wrong in requests for one."""

import sys
from typing import Any

import numpy as np
import pytest

import layflat as lf
from layflat.linear import linearize, measure_response

control = pytest.importorskip("control")

GAIN_TOLERANCE, PHASE_TOLERANCE = 0.02, 3.0  # of the linear model from 0.5 to 20 Hz: fraction, deg


def errors(model: Any, outputs: list[str]) -> tuple[float, float]:
    """Return the largest errors of a model against the plant, of each joint's outputs to its own valve."""
    measured = measure_response(model)
    joints = list(model.operating_point.machine.joints)
    ratios = [
        model[f"{joint}_{output}", f"{joint}_voltage"](1j * measured.omega)
        / measured[f"{joint}_{output}", f"{joint}_voltage"](1j * measured.omega)
        for joint in joints
        for output in outputs
    ]
    assert len(measured.omega) > 10
    return float(np.abs(np.abs(ratios) - 1.0).max()), float(np.degrees(np.abs(np.angle(ratios))).max())


@pytest.mark.parametrize(
    ("joints", "outputs"), [("held", ["differential_pressure"]), ("sliding", ["velocity", "differential_pressure"])]
)
def test_a_linear_model_has_the_response_of_the_plant(joints: str, outputs: list[str]) -> None:
    gain, phase = errors(lf.linearize("paper-arm-tracking", joints=joints), outputs)
    assert gain < GAIN_TOLERANCE
    assert phase < PHASE_TOLERANCE


def test_one_hose_lifts_a_load_against_gravity() -> None:
    gain, phase = errors(linearize("single-joint-lift"), ["velocity"])
    assert gain < GAIN_TOLERANCE
    assert phase < PHASE_TOLERANCE


def test_a_load_moves_a_joint_as_in_the_plant() -> None:
    model = linearize("single-joint-lift")
    measured = measure_response(model, (0.5, 1.0, 2.0, 5.0, 10.0), inputs=["small_load"])  # a load acts at once
    s, velocity, load = 1j * measured.omega, "small_velocity", "small_load"
    ratio = model[velocity, load](s) / measured[velocity, load](s)
    assert ratio == pytest.approx(np.ones(len(ratio)), abs=0.02)


def test_signals_and_states_have_names_and_units() -> None:
    model = lf.linearize("paper-arm", joints={"small": "sliding"})
    assert model.input_labels == ["large_voltage", "small_voltage", "small_load"]
    assert "large_angle" not in model.output_labels
    assert {"small_angle", "small_velocity", "small_opening", "large_temperature_b"} <= set(model.state_labels)
    assert model.units["small_velocity"] == "rad/s"
    assert set(model.units) == {*model.state_labels, *model.input_labels, *model.output_labels}


def test_the_plant_stays_at_the_operating_point() -> None:
    from layflat.linear.response import simulate

    point = linearize("paper-arm").operating_point
    motion = simulate(point, np.zeros((400, 2)), np.zeros((2, 400, 2)))
    assert motion[-100:, 1].mean(axis=0) == pytest.approx([state.velocity for state in point.states], rel=0.1)
    assert motion[-100:, 2].mean(axis=0) == pytest.approx([state.air_a.pressure for state in point.states], rel=2e-3)


def test_delays_of_a_valve_are_those_of_its_cycles() -> None:
    machine, cycle = lf.changed(lf.load("paper-small-joint"), "valve.delay", "7.5 ms"), 5e-3
    prompt, late = linearize("paper-small-joint", joints="held"), linearize(machine, joints="held")
    s = 2j * np.pi * np.array([1.0, 5.0, 20.0])
    output, voltage = "small_differential_pressure", "small_voltage"
    ratio = late[output, voltage](s) / prompt[output, voltage](s)
    assert ratio == pytest.approx(0.5 * np.exp(-cycle * s) + 0.5 * np.exp(-2.0 * cycle * s), abs=1e-3)


def test_sliding_back_is_the_mirror_of_sliding_forward() -> None:
    forward, back = (linearize("paper-small-joint", speed=speed) for speed in ("1 deg/s", "-1 deg/s"))
    s = 2j * np.pi * 3.0
    pair = [abs(model["small_velocity", "small_voltage"](s)) for model in (forward, back)]
    assert pair[0] == pytest.approx(pair[1], rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"joints": "slidng"}, "did you mean 'sliding'"),
        ({"joints": {"elbow": "held"}}, "unknown joint 'elbow'"),
        ({"pressures": ("9 bar", "2 bar")}, "9 bar is beyond .* give absolute pressures of 1.013 to 5.013 bar"),
        ({"pressures": ("3 bar", "3 bar")}, "9.7 N m are missing at joint 'large'; to slide it needs about 0.47"),
        ({"pressures": ("5 bar", "1.1 bar"), "joints": "held"}, "80.1 N m are missing at joint 'large'"),
        ({"speed": "0 deg/s"}, "is no speed to slide at"),
        ({"speed": "0.01 deg/s"}, "reverses joint 'large' .* give more than 0.03"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(lf.InputError, match=line):
        linearize("paper-arm", **changes)


def test_valves_that_pulse_near_their_shortest_pulse_have_no_linear_model() -> None:
    for joints in ("held", "sliding"):
        with pytest.raises(lf.InputError, match=r"the valve of joint '\w+' does not respond"):
            linearize("paper-arm-switching", joints=joints)


def test_the_torque_that_a_load_lacks_is_named() -> None:
    heavy = lf.changed(lf.load("single-joint-lift"), "arm.payload", "30 kg")
    with pytest.raises(lf.InputError, match=r"joint 'small' lacks .* N m to hold: the load takes"):
        linearize(heavy, joints="held")


def test_a_missing_package_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(lf.MissingExtraError, match="linearize"):
        linearize("paper-arm")
