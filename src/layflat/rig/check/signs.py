"""Which way valves and sensors go: with air on, each valve is opened slowly to either side until its joint stirs."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.rig.check.open_loop import CheckResult, OpenLoopRig, UnsafeError
from layflat.rig.safety.state_machine import RESET_HIGH, RESET_LOW

STIRS = np.radians(1.5)  # a joint that went so far is stopped; it swings on by some degrees, on the air that it has
SINKS = np.radians(15.0)  # one that gravity moves may go so far meanwhile
RATE = 0.05  # share of its full opening by which the valve opens; faster pulses throw a light joint further, 1/s
LONGEST = 5.0  # until something has to have stirred, s
ANSWERS = 0.1e5  # change of a differential pressure that is an answer, Pa
MOST = 0.8  # share of the supply's pressure, at which a joint that does not stir is taken to be blocked
MEAN = 4  # cycles over which samples are averaged: a period of the dither
RESTS = 1.0  # between two pulses, and after the air has come: hoses get air through the valves' leaks, s


class Pulse(NamedTuple):
    """What came of opening a valve."""

    way: int  # 1: towards filling hose A, -1: hose B
    opening: float  # reached, of full
    angles: Array  # changes, rad, (joints,)
    pressures: Array  # changes, Pa, (joints,)


def try_signs(bench: OpenLoopRig, tell: Callable[[str], object] = str) -> list[CheckResult]:
    """Bring the air to a rig that is sound without, try every joint, let the air out again, whatever happens."""
    findings: list[CheckResult] = []
    bench.driver.activate()
    try:
        tell("soft start")
        findings.append(_bring_air(bench))
        if findings[-1].passed:
            for joint, name in enumerate(bench.names):
                tell(f"joint {name}")
                findings.append(judged([_pulse(bench, joint, way) for way in (1, -1)], joint, bench.names))
    except UnsafeError as error:
        findings.append(CheckResult("ended early", str(error), "find the cause; the air was let out"))
    finally:
        tell("letting the air out")
        bench.vent()
    return findings


def _bring_air(bench: OpenLoopRig) -> CheckResult:
    safety, supply = bench.machine.safety, bench.machine.supply
    ready, edge = supply.ambient_pressure + safety.supply_ready * supply.pressure_gauge, RESET_LOW + RESET_HIGH
    for k in range(edge):
        reading = bench.act(bench.centred, reset=k >= RESET_LOW)
    for took in range(edge + 1, bench.cycles(safety.start_time) + 2):
        reading = bench.act(bench.centred)
        if reading.supply >= ready:
            bench.rest(RESTS)
            return CheckResult("air", f"there {took * bench.cycle:.2f} s after it was asked for")
    gauge = (reading.supply - supply.ambient_pressure) / 1e5
    right = "look at compressor, regulator, dump valve and the sensor behind it"
    return CheckResult("air", f"{gauge:.2f} bar after {safety.start_time:g} s", right)


def _pulse(bench: OpenLoopRig, joint: int, way: int) -> Pulse:
    """Open a valve slowly until its joint, or one that should be at rest, stirs; it is centred at once then."""
    recent = [bench.act(bench.centred) for _ in range(MEAN)]
    angles, pressures = np.mean([r.angles for r in recent], axis=0), np.mean([r.pressures for r in recent], axis=0)
    voltages, opening = bench.centred.copy(), 0.0
    own = np.arange(len(bench.names)) == joint
    for k in range(bench.cycles(LONGEST)):
        opening = RATE * (k + 1) * bench.cycle
        voltages[joint] = bench.centred[joint] + way * opening * bench.span
        recent = [*recent[1:], bench.act(voltages)]
        by = np.mean([r.pressures for r in recent], axis=0) - pressures
        blocked = np.abs(by).max() > MOST * bench.machine.supply.pressure_gauge
        # Joints sink while hoses fill and leak: such a motion is a valve's if its pressure answers.
        moved = bench.sinking & ~(own & (np.abs(by) > ANSWERS))
        if blocked or (np.abs(recent[-1].angles - angles) > np.where(moved, SINKS, STIRS)).any():
            break
    pulse = Pulse(way, opening, recent[-1].angles - angles, by)
    bench.rest(RESTS)
    return pulse


# What is wrong, by the ways that angle and pressure went when hose A was to be filled, then hose B.
WRONG: dict[tuple[int, ...], str] = {
    (1, 1, 1, 1): "",
    (-1, -1, -1, -1): "its valve goes the wrong way: swap its two hoses",
    (1, 1, -1, -1): "its pressure sensor goes the wrong way: swap its two lines",
    (-1, -1, 1, 1): "its angle sensor goes the wrong way: turn its sign",
    (0, 0, 0, 0): "nothing stirs: look at the plug of its valve, and at its lines",
}


def judged(pulses: list[Pulse], joint: int, names: list[str]) -> CheckResult:
    """What two pulses of a joint's valve, one each way, say of its valve and sensors."""
    turned = [_sign(pulse.way * pulse.angles[joint], STIRS / 2) for pulse in pulses]
    pressed = [_sign(pulse.way * pulse.pressures[joint], ANSWERS) for pulse in pulses]
    if other := _other(pulses, joint, names):
        wrong = f"its valve moves {other}: swap their plugs or hoses"
    elif not any(turned):
        wrong = "it does not turn: it is blocked, or its angle sensor is loose"
    elif not any(pressed):
        wrong = "its pressure does not answer: look at the pressure sensor's lines"
    else:
        wrong = "it does not go one way with its valve: look at the valve's centre, and for leaks"
    found = "; ".join(
        f"{pulse.way * 100 * pulse.opening:+.1f} % open gave {pulse.pressures[joint] / 1e5:+.2f} bar, "
        f"{np.degrees(pulse.angles[joint]):+.1f} deg"
        for pulse in pulses
    )
    return CheckResult(f"signs of {names[joint]}", found, wrong if other else WRONG.get((*turned, *pressed), wrong))


def _other(pulses: list[Pulse], joint: int, names: list[str]) -> str:
    """Another joint whose pressure answered instead; empty if none did."""
    for pulse in pulses:
        most = int(np.abs(pulse.pressures).argmax())
        other = abs(pulse.pressures[most])
        if most != joint and other > 3.0 * ANSWERS and abs(pulse.pressures[joint]) < other / 3.0:
            return names[most]
    return ""


def _sign(value: float, least: float) -> int:
    return int(np.sign(value)) if abs(value) >= least else 0
