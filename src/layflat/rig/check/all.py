"""The whole check of a rig: link, timing, device, e-stop, supply and every sensor without air, then signs with air."""

from collections import Counter
from collections.abc import Callable

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.machine.parameters import sensor
from layflat.physics.sensor import Sensor
from layflat.rig.abilities import resting_angles
from layflat.rig.check.open_loop import CheckResult, OpenLoopRig
from layflat.rig.check.signs import try_signs
from layflat.rig.clock import Clock
from layflat.rig.driver import Driver

SECONDS = 2.0  # for which a rig is looked at, s
FEW = 0.01  # share of replies that may be lost, and of cycles that may be late by more than a cycle
PART = 20  # samples of which the noise is taken
NO_PRESSURE = 0.1e5  # what an empty line or joint may show, Pa
LIVELY = 0.2  # noise in counts from which on a sound sensor changes within `SECONDS`
NOISY, CALM = 5.0, 0.5  # times the noise of the description, beyond which and below which something is wrong

DOES = ("obeys", "has centred the valves", "has let out the air")  # what the device does by itself, by its state


def check_rig(
    machine: Machine, driver: Driver, clock: Clock, *, air: bool = False, tell: Callable[[str], object] = str
) -> list[CheckResult]:
    """Look at a rig without air, and if that finds nothing wrong and it is asked for, with air: every joint moves.

    The driver comes unconfigured and is finalized afterwards; `tell` is called with what is being done.

    Raises:
        DriverError: nothing that fits is there.
        InputError: it has other joints, voltages or times than the machine.
    """
    try:
        able = driver.configure()
        able.check(machine)
        volts = f"{able.voltage_low:g} to {able.voltage_high:g} V, closed at {able.centre_voltage:g} V"
        findings = [CheckResult("device", f"{able.joints} joints, {volts}, as described")]
        bench = OpenLoopRig(machine, driver, clock)
        tell("looking on")
        findings += _look(bench)
        if air and all(one.passed for one in findings):
            findings += try_signs(bench, tell)
        elif air:
            findings.append(CheckResult("air", "not tried", "see to the failed checks first"))
        return findings
    finally:
        driver.finalize()


def _look(bench: OpenLoopRig) -> list[CheckResult]:
    """Look at a rig that is not moved."""
    found = [reading for _ in range(bench.cycles(SECONDS)) if (reading := bench.look()) is not None]
    late, asked = bench.deadlines, len(found) + len(bench.failures)
    findings = [_link(bench, len(found), asked)]
    told = (
        f"{1e6 * late.lateness_at(0.5):.0f} us late at the median, {1e6 * late.lateness_at(0.99):.0f} us at 99 %, "
        f"{late.missed} cycles missed"
    )
    right = "run nothing else on this computer, or take a longer cycle" if late.missed > FEW * asked else ""
    findings.append(CheckResult("cycles", told, right))
    if not found:
        return findings
    if found[-1].stopped:
        findings.append(CheckResult("e-stop", "pressed", "release it"))
    else:
        findings.append(CheckResult("e-stop", f"released; the device {DOES[found[-1].device]}"))
    gauge = float(np.mean([reading.supply for reading in found])) - bench.machine.supply.ambient_pressure
    right = "shut off the air and vent the line, or set the sensor's zero" if abs(gauge) > NO_PRESSURE else ""
    findings.append(CheckResult("supply", f"{gauge / 1e5:+.2f} bar gauge, air off", right))
    for j, name in enumerate(bench.names):
        findings.append(_angle(bench, j, name, np.array([reading.angles[j] for reading in found])))
        findings.append(_pressure(bench, j, name, np.array([reading.pressures[j] for reading in found])))
    return findings


def _link(bench: OpenLoopRig, came: int, asked: int) -> CheckResult:
    """Tell how many replies came, and of those that did not the usual reason."""
    median = 1e6 * float(np.median(bench.transactions))
    found = f"{came} of {asked} good replies came, {median:.0f} us at the median"
    if bench.driver.remark:
        found += f", {bench.driver.remark}"
    if not bench.failures:
        return CheckResult("link", found)
    told = [one for one in bench.failures if one.right] or bench.failures  # a refusal says more than a late reply
    (usual, right), count = Counter((one.reason, one.right) for one in told).most_common(1)[0]
    if usual:
        found += f"; {usual}" + (f" ({count} times)" if count < asked else "")
    right = right or "look at cable and load of the device, and at `timeout` in [interface]"
    return CheckResult("link", found, right if len(bench.failures) > FEW * asked else "")


def _angle(bench: OpenLoopRig, j: int, name: str, samples: Array) -> CheckResult:
    rail, middle, wrong = bench.limits[j].rail, float(np.median(samples)), ""
    own, lives = sensor(bench.angle_part), bench.limits[j].angle_frozen.noisy > 0.0
    end = float(resting_angles(bench.machine)[j])
    if not rail.low < middle < rail.high:
        wrong = "at its rail: it is open or shorted, look at its wires"
    elif abs(middle) > end:
        wrong = f"outside the mechanical stroke, {np.degrees(end):.0f} deg either way: set its zero"
    elif lives and 0.0 < noise_of(samples) < CALM * own.noise:
        wrong = "less noise than described, so that it would be taken for frozen at rest: describe its own"
    return _sensor(f"angle of {name}", f"{np.degrees(middle):.2f} deg", own, samples, wrong)


def _pressure(bench: OpenLoopRig, j: int, name: str, samples: Array) -> CheckResult:
    middle, wrong = float(np.median(samples)), ""
    if not abs(middle) < bench.limits[j].over_pressure:
        wrong = "at its rail: look at its wires"
    elif abs(middle) > NO_PRESSURE:
        wrong = "let the air out of the hoses, or set its zero"
    return _sensor(f"pressure of {name}", f"{middle / 1e5:+.3f} bar", sensor(bench.pressure_part), samples, wrong)


def noise_of(samples: Array) -> float:
    """Standard deviation of what is noise in samples, although a joint may sink meanwhile, and meet its stop.

    Motion is taken out by second differences, and a jolt by the median of some parts; 0 of less than three samples.
    """
    bends = np.diff(samples, 2) / np.sqrt(6.0)
    parts = np.array_split(bends, max(len(bends) // PART, 1))
    return float(np.median([np.std(part) for part in parts])) if len(bends) else 0.0


def _sensor(what: str, shown: str, law: Sensor, samples: Array, wrong: str) -> CheckResult:
    """Tell of a sensor what is wrong with its values, or else with its noise."""
    noise = noise_of(samples)
    if not wrong and law.noise > LIVELY * law.lsb and np.ptp(samples) == 0.0:
        wrong = "it repeats itself: its converter is frozen, or the wire is off"
    elif not wrong and noise > NOISY * (law.noise**2 + law.lsb**2 / 12.0) ** 0.5 + law.lsb:
        wrong = "much noise: look at its screen and ground"
    return CheckResult(what, f"{shown}, noise {noise / law.lsb:.1f} counts", wrong)
