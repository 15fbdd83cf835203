"""Check of the signs of a rig's valves and sensors with air: each joint moves by some degrees, one after the other.

A valve at rest is centred; that of a single hose is open to the exhaust, and is checked by filling the empty hose.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.rig.open_loop import CheckResult, OpenLoopRig, UnsafeError
from layflat.rig.safety.state_machine import RESET_HIGH_CYCLES, RESET_LOW_CYCLES

MAX_TEST_ANGLE = np.radians(1.5)  # motion that ends a pulse; the joint moves on by some degrees, on the air it has
MAX_SINK_ANGLE = np.radians(15.0)  # the same of a joint that gravity moves
OPENING_RATE = 0.05  # of full opening, at which the valve opens; faster pulses throw a light joint further, 1/s
MAX_PULSE_TIME = 5.0  # within which a pulse has to move something, s
MIN_PRESSURE_RESPONSE = 0.1e5  # change of a differential pressure that is a response, Pa
BLOCKED_PRESSURE_FRACTION = 0.8  # of the supply's gauge pressure, at which a joint that does not move is blocked
AVERAGED_CYCLES = 4  # cycles over which samples are averaged: a period of the dither
REST_TIME = 1.0  # between two pulses, and after the soft start: hoses fill through the valves' leaks, s
MAX_REST_TIME = 15.0  # within which joints with a single hose come to rest, s
# Diagnosis by the signs of the responses of the angle to pulses towards hose A and B, then of the pressure to both.
SIGN_DIAGNOSES: dict[tuple[int, ...], str] = {
    (1, 1, 1, 1): "",
    (-1, -1, -1, -1): "its valve goes the wrong way: swap its two hoses",
    (1, 1, -1, -1): "its pressure sensor goes the wrong way: swap its two lines",
    (-1, -1, 1, 1): "its angle sensor goes the wrong way: turn its sign",
    (0, 0, 0, 0): "nothing stirs: look at the plug of its valve, and at its lines",
}


class ValvePulse(NamedTuple):
    """Response to a pulse, which opens a valve slowly in one direction."""

    direction: int  # 1: fills hose A, -1: fills hose B
    opening: float  # reached, as a fraction of full opening; below 0 towards hose B or the exhaust
    angles: Array  # changes, rad, (joints,)
    pressures: Array  # changes, Pa, (joints,)


def check_signs(bench: OpenLoopRig, tell: Callable[[str], object] = str) -> list[CheckResult]:
    """Supply air to a rig that passed the checks without, test the signs of every joint, and vent it in any case.

    `tell` is called with the name of each step. A fault ends the test: it is the last result, no error.
    """
    findings: list[CheckResult] = []
    bench.driver.activate()
    try:
        tell("soft start")
        findings.append(_supply_air(bench))
        if findings[-1].has_passed:
            for joint, name in enumerate(bench.names):
                tell(f"joint {name}")
                pulses = [_apply_pulse(bench, joint, sign) for sign in (1, -1)]
                findings.append(judge_pulses(pulses, joint, bench.names, single=bool(bench.is_single[joint])))
    except UnsafeError as error:
        findings.append(CheckResult("ended early", str(error), "find the cause; the air was vented"))
    finally:
        tell("venting the air")
        bench.vent()
    return findings


def _supply_air(bench: OpenLoopRig) -> CheckResult:
    """Supply air with valves at rest; return the result: the time until it is ready, or failure after `start_time`.

    Errors as from `OpenLoopRig.act`, and UnsafeError for a joint with a single hose that moves.
    """
    safety, supply = bench.machine.safety, bench.machine.supply
    ready = supply.ambient_pressure + safety.supply_ready * supply.pressure_gauge
    edge = RESET_LOW_CYCLES + RESET_HIGH_CYCLES
    first = bench.act(bench.resting).angles
    for k in range(1, bench.cycles(safety.start_time) + 1):
        reading = bench.act(bench.resting, reset=RESET_LOW_CYCLES <= k < edge)
        _check_vented_joints(bench, reading.angles - first)
        if k >= edge and reading.supply >= ready:
            for _ in range(bench.cycles(REST_TIME)):
                _check_vented_joints(bench, bench.act(bench.resting).angles - first)
            return CheckResult("air", f"there {(k + 1) * bench.cycle:.2f} s after it was asked for")
    gauge = (reading.supply - supply.ambient_pressure) / 1e5
    right = "look at compressor, regulator, dump valve and the sensor behind it"
    return CheckResult("air", f"{gauge:.2f} bar after {safety.start_time:g} s", right)


def _check_vented_joints(bench: OpenLoopRig, motions: Array) -> None:
    """Raise UnsafeError for the first joint with a single hose that moved though its valve vents it.

    Args:
        bench: rig whose valves are at rest.
        motions: changes of the angles, rad, (joints,).
    """
    for name, single, motion in zip(bench.names, bench.is_single, motions, strict=True):
        if single and abs(motion) > MAX_TEST_ANGLE:
            what = f"joint {name!r}: moves though its valve vents its hose"
            raise UnsafeError(f"{what}; put the hose on the valve's other port, or look at the valve's plug")


def _apply_pulse(bench: OpenLoopRig, joint: int, direction: int) -> ValvePulse:
    """Open a valve slowly until any joint moves, a pressure nears the supply's, or `MAX_PULSE_TIME` is over.

    Return the response at the end of the opening, after a rest; errors as from `act`. Joints that gravity
    moves may sink by `MAX_SINK_ANGLE` before they count as moving.
    """
    recent = [bench.act(bench.resting) for _ in range(AVERAGED_CYCLES)]
    angles, pressures = np.mean([r.angles for r in recent], axis=0), np.mean([r.pressures for r in recent], axis=0)
    voltages = bench.resting.copy()
    is_tested = np.arange(len(bench.names)) == joint
    for k in range(bench.cycles(MAX_PULSE_TIME)):
        voltages[joint] = bench.resting[joint] + direction * OPENING_RATE * (k + 1) * bench.cycle * bench.span
        recent = [*recent[1:], bench.act(voltages)]
        change = np.mean([r.pressures for r in recent], axis=0) - pressures
        blocked = np.abs(change).max() > BLOCKED_PRESSURE_FRACTION * bench.machine.supply.pressure_gauge
        # Joints sink while hoses fill and leak: the valve causes such a motion if the joint's pressure responds.
        sinks = bench.sinking & ~(is_tested & (np.abs(change) > MIN_PRESSURE_RESPONSE))
        if blocked or (np.abs(recent[-1].angles - angles) > np.where(sinks, MAX_SINK_ANGLE, MAX_TEST_ANGLE)).any():
            break
    opening = (voltages[joint] - bench.centred[joint]) / bench.span
    pulse = ValvePulse(direction, opening, recent[-1].angles - angles, change)
    _let_rest(bench)
    return pulse


def _let_rest(bench: OpenLoopRig) -> None:
    """Keep the valves at rest with air on for `REST_TIME`, again until joints with a single hose stand still.

    It ends within `MAX_REST_TIME`; errors as from `OpenLoopRig.act`.
    """
    for _ in range(round(MAX_REST_TIME / REST_TIME)):
        angles = [bench.act(bench.resting).angles for _ in range(bench.cycles(REST_TIME))]
        if not (bench.is_single & (np.abs(angles[-1] - angles[0]) > MAX_TEST_ANGLE / 2)).any():
            return


def judge_pulses(pulses: list[ValvePulse], joint: int, names: list[str], *, single: bool = False) -> CheckResult:
    """Return the result of the check of a joint's valve and sensors by their signs.

    Args:
        pulses: responses to two pulses, one in each direction.
        joint: number of the joint whose valve was opened.
        names: names of the joints, from base to tip.
        single: whether the joint has a single hose: that is vented before each pulse, and may not answer to venting.
    """
    turned = [_sign(pulse.direction * pulse.angles[joint], MAX_TEST_ANGLE / 2) for pulse in pulses]
    pressed = [_sign(pulse.direction * pulse.pressures[joint], MIN_PRESSURE_RESPONSE) for pulse in pulses]
    if single:
        turned[1], pressed[1] = turned[1] or turned[0], pressed[1] or pressed[0]
    if other := _find_responding_joint(pulses, joint, names):
        wrong = f"its valve moves {other}: swap their plugs or hoses"
    elif not any(turned):
        wrong = "it does not turn: it is blocked, or its angle sensor is loose"
    elif not any(pressed):
        wrong = "its pressure does not answer: look at the pressure sensor's lines"
    else:
        wrong = "it does not go one way with its valve: look at the valve's centre, and for leaks"
    responses = "; ".join(
        f"{100 * pulse.opening:+.1f} % open gave {pulse.pressures[joint] / 1e5:+.2f} bar, "
        f"{np.degrees(pulse.angles[joint]):+.1f} deg"
        for pulse in pulses
    )
    return CheckResult(
        f"signs of {names[joint]}", responses, wrong if other else SIGN_DIAGNOSES.get((*turned, *pressed), wrong)
    )


def _find_responding_joint(pulses: list[ValvePulse], joint: int, names: list[str]) -> str:
    """Return the name of another joint that answers: the first with the greatest pressure change of a pulse; else ''.

    That change must exceed 3 times the tested joint's, and 3 times `MIN_PRESSURE_RESPONSE`.
    """
    for pulse in pulses:
        strongest = int(np.abs(pulse.pressures).argmax())
        response = abs(pulse.pressures[strongest])
        tested = abs(pulse.pressures[joint])
        if strongest != joint and response > 3.0 * MIN_PRESSURE_RESPONSE and tested < response / 3.0:
            return names[strongest]
    return ""


def _sign(value: float, threshold: float) -> int:
    """Return 1 or -1, the sign of a value of at least the threshold; 0 below it."""
    return int(np.sign(value)) if abs(value) >= threshold else 0
