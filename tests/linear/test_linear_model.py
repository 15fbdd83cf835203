"""Linear models against the plant that they stand for, and what is wrong in requests for one."""

import sys
from typing import Any

import numpy as np
import pytest

import layflat as lf
from layflat.description.change import changed_all
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


SMALL_LOSSES, PRESSURES = "joint.small.losses", {"reference_pressure_gauge": "3 bar", "pressure_free": 0.25}
CREEP = {"kind": "creep", "deflection": "2 deg", "per_decade": 0.1, "first": "10 ms", "last": "10 s"}
MAXWELL = {"kind": "maxwell", "deflection": "2 deg", "times": ["20 ms", "1 s"], "weights": [0.5, 0.2]}
BOUC_WEN = {"kind": "bouc-wen", "deflection": "1.5 deg", "beta": 0.7, "exponent": 1.5, "hardening": 0.05}
STRIBECK = {"kind": "stribeck", "static_ratio": 1.05, "velocity": "0.5 deg/s", "load_ratio": 0.01}


@pytest.mark.parametrize(
    ("machine", "changes", "options"),
    [
        ("earlier-actuator", {"arm.payload": "0.4 kg"}, {"configuration": "-30 deg", "joints": "held"}),
        ("single-joint-lift", {}, {}),  # one hose lifts a load against gravity
        ("earlier-actuator", {}, {}),  # webbing straps on a round roller
        ("paper-small-joint-fast", {SMALL_LOSSES: CREEP | PRESSURES}, {}),
        ("paper-small-joint-fast", {SMALL_LOSSES: MAXWELL | PRESSURES}, {"configuration": "30 deg"}),
        ("paper-small-joint", {}, {"speed": "-20 deg/s"}),
        ("paper-small-joint", {"joint.small.friction": STRIBECK}, {"speed": "2 deg/s"}),
        (
            "paper-small-joint",
            {SMALL_LOSSES: CREEP | PRESSURES, "joint.small.friction": STRIBECK},
            {"speed": "3 deg/s"},
        ),
        ("paper-small-joint", {SMALL_LOSSES: BOUC_WEN | PRESSURES}, {"configuration": "-30 deg"}),  # hardly damped
        ("paper-small-joint-fast", {"line": {"length": "0.5 m", "bore": "4 mm"}}, {}),
        ("paper-small-joint-fast", {"line": {"length": "1 m", "bore": "4 mm"}}, {"joints": "held"}),
    ],
)
def test_other_machines_respond_as_their_plants(machine: str, changes: dict[str, Any], options: dict[str, Any]) -> None:
    output = "differential_pressure" if "held" in options.values() else "velocity"
    gain, phase = errors(linearize(changed_all(lf.load(machine), changes), **options), [output])
    assert gain < GAIN_TOLERANCE
    assert phase < PHASE_TOLERANCE


def test_joints_that_move_each_other_respond_as_their_plant() -> None:
    """Elbow and wrist move in opposition at 7.5 Hz, where slow damping by the ripple acts as a spring."""
    model = linearize("picking-arm", joints={"elbow": "sliding", "wrist": "sliding"})
    measured = measure_response(model, (0.75, 2.0, 4.0, 7.0, 7.5, 8.0, 10.0, 15.0), inputs=["elbow_voltage"])
    for joint in ("elbow", "wrist"):
        s, velocity = 1j * measured.omega, f"{joint}_velocity"
        ratio = model[velocity, "elbow_voltage"](s) / measured[velocity, "elbow_voltage"](s)
        assert np.abs(np.abs(ratio) - 1.0).max() < GAIN_TOLERANCE
        assert np.degrees(np.abs(np.angle(ratio))).max() < PHASE_TOLERANCE


def test_an_arm_that_falls_over_responds_as_its_plant() -> None:
    """Gravity alone doubles a deviation in 4 s; while it is measured, the arm neither falls nor slides away."""
    machine = lf.changed(lf.load("picking-arm"), "arm.payload", "0.47 kg")
    model = linearize(machine, configuration=("1 deg", "49 deg", "-38 deg", "48 deg"))
    assert 0.1 < model.poles().real.max() < 0.3
    measured = measure_response(model, (1.0, 2.0, 2.5, 3.0, 4.0), inputs=["base_voltage"])
    for output in ("base_velocity", "base_differential_pressure"):
        ratio = model[output, "base_voltage"](1j * measured.omega) / measured[output, "base_voltage"](
            1j * measured.omega
        )
        assert np.abs(np.abs(ratio) - 1.0).max() < GAIN_TOLERANCE
        assert np.degrees(np.abs(np.angle(ratio))).max() < PHASE_TOLERANCE


def test_pressure_and_velocity_respond_as_in_the_plant_at_pressures_that_drift() -> None:
    light = lf.changed(lf.load("single-joint-lift"), "arm.payload", "0.07 kg")
    model = linearize(light, configuration="-10 deg")  # sidebands of the dither are beside a small response here
    gain, phase = errors(model, ["velocity", "differential_pressure"])
    assert gain < 0.5 * GAIN_TOLERANCE
    assert phase < 0.5 * PHASE_TOLERANCE
    drifting = linearize("paper-small-joint", configuration="-23 deg", pressures=("3.32 bar", "2.79 bar"))
    assert np.abs(drifting.operating_point.drift).max() > 1e4  # Pa/s
    gain, phase = errors(drifting, ["velocity", "differential_pressure"])
    assert gain < 0.5 * GAIN_TOLERANCE
    assert phase < 0.5 * PHASE_TOLERANCE


@pytest.mark.parametrize(
    "pressures",
    [
        {"large": ("4.633 bar", "4.123 bar"), "small": ("4.646 bar", "4.111 bar")},
        {"large": ("2.189 bar", "1.767 bar"), "small": ("2.202 bar", "1.755 bar")},  # rises by 1.7 bar/s
    ],
)
def test_an_arm_at_other_pressures_responds_as_its_plant(pressures: dict[str, tuple[str, str]]) -> None:
    """Elements of the hysteresis stick for whole steps of the plant: only its own ripple says for how many."""
    gain, phase = errors(linearize("paper-arm-tracking", pressures=pressures), ["velocity", "differential_pressure"])
    assert gain < 0.5 * GAIN_TOLERANCE
    assert phase < 0.5 * PHASE_TOLERANCE


def test_joints_that_stick_and_slip_have_no_response_to_measure() -> None:
    falling = changed_all(lf.load("paper-small-joint"), {"joint.small.friction": STRIBECK | {"static_ratio": 1.4}})
    with pytest.raises(lf.InputError, match=r"speed: joints do not slide steadily: .* give a higher one"):
        measure_response(linearize(falling))


def test_a_configuration_that_no_opening_holds_is_named() -> None:
    with pytest.raises(lf.InputError, match=r"no opening of the valves .* a lower speed"):
        linearize(lf.changed(lf.load("paper-small-joint"), "valve.conductance", 8e-11), speed="50 deg/s")


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
    (motion,) = simulate(point, np.zeros((2, 400, 2)))
    velocities = [[state.velocity + end for state, end in zip(point.states, point.ends[-1, :, 1], strict=True)]]
    assert motion[-100::4, 1].mean(axis=0) == pytest.approx(velocities[0], rel=0.01)
    assert motion[-100:, 2].mean(axis=0) == pytest.approx([state.air_a.pressure for state in point.states], rel=1e-3)


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
        (
            {"pressures": ("5 bar", "1.1 bar"), "joints": "held"},
            "80.1 N m are missing at joint 'large'; .* about 0.000 bar",
        ),
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


def test_a_valve_that_sticks_without_dither_has_no_linear_model() -> None:
    without = lf.changed(lf.load("paper-small-joint"), "valve.dither.amplitude", 0.0)
    with pytest.raises(lf.InputError, match=r"does not respond at an opening of .* give it dither"):
        linearize(without, speed="10 deg/s")


def test_the_torque_that_a_load_lacks_is_named() -> None:
    heavy = lf.changed(lf.load("single-joint-lift"), "arm.payload", "30 kg")
    with pytest.raises(lf.InputError, match=r"joint 'small' lacks .* N m to hold: the load takes"):
        linearize(heavy, joints="held")


def test_a_missing_package_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(lf.MissingExtraError, match="linearize"):
        linearize("paper-arm")
