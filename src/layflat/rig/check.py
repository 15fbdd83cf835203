"""The whole check of a rig: link, timing, device, e-stop, supply and every sensor without air, then signs with air."""

import gc
import signal
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.parameters import sensor
from layflat.parallel import end_process, start_process
from layflat.physics.sensor import Sensor
from layflat.rig.abilities import resting_angles
from layflat.rig.clock import LoopClock, MonotonicClock
from layflat.rig.driver import Capabilities, Driver
from layflat.rig.open_loop import CheckResult, OpenLoopRig
from layflat.rig.signs import check_signs
from layflat.rig.system import set_fifo_priority

CHECK_DURATION = 2.0  # for which a rig is observed without air, s
MAX_LOST_FRACTION = 0.01  # of replies that may be lost, and of cycles that may be late by more than a cycle
NOISE_BLOCK_SAMPLES = 20  # samples of a block of which the noise is estimated
MAX_VENTED_PRESSURE = 0.1e5  # gauge pressure that an empty line or joint may report, Pa
MIN_CHANGING_NOISE = 0.2  # noise in counts from which on a valid sensor changes within `CHECK_DURATION`
MAX_NOISE_RATIO, MIN_NOISE_RATIO = 5.0, 0.5  # measured noise over that of the description; outside, the sensor fails

NO_OPEN_LOOP = "check it without air, or give it firmware that obeys voltages"

# By DeviceState.
DEVICE_STATE_TEXTS = ("obeys", "has centred the valves", "has vented the air")
POLL_INTERVAL = 0.05  # between two polls of whether to go on, s
VENT_TIMEOUT = 15.0  # within which a check that is broken off vents the hoses, s


def check_rig(
    machine: Machine, driver: Driver, clock: LoopClock, *, air: bool = False, tell: Callable[[str], object] = str
) -> list[CheckResult]:
    """Check a rig without air and, if that passes and `air` is set, with air: every joint moves.

    Args:
        machine: description of the rig.
        driver: unconfigured driver of the rig; it is finalized afterwards.
        clock: clock of the control cycles.
        air: whether to check with air, too.
        tell: called with the name of each step.

    Returns:
        A result for each check in turn; a check that fails, or ends early, raises nothing.

    Raises:
        DriverError: no fitting device answers.
        InputError: the device has other joints, voltages or times than the machine.
    """
    try:
        able = driver.configure()
        able.check(machine)
        findings = [CheckResult("device", describe_device(able))]
        bench = OpenLoopRig(machine, driver, clock)
        tell("looking on")
        findings += _check_without_air(bench)
        if air and driver.runs_law:
            findings.append(CheckResult("air", "not tried: the device runs its control law itself", NO_OPEN_LOOP))
        elif air and all(one.has_passed for one in findings):
            findings += check_signs(bench, tell)
        elif air:
            findings.append(CheckResult("air", "not tried", "see to the failed checks first"))
        return findings
    finally:
        driver.finalize()


def describe_device(able: Capabilities) -> str:
    """Return the finding of the check of a device that is as described."""
    volts = f"{able.voltage_low:g} to {able.voltage_high:g} V, closed at {able.centre_voltage:g} V"
    return f"{able.joints} joints, {volts}, as described"


def _check_without_air(bench: OpenLoopRig) -> list[CheckResult]:
    """Return the results of link, timing, e-stop, supply and all sensors from 2 s of readings without air.

    Where no reply came there are only those of link and timing.
    """
    readings = [reading for _ in range(bench.cycles(CHECK_DURATION)) if (reading := bench.read()) is not None]
    late, requests = bench.deadlines, len(readings) + len(bench.failures)
    findings = [_check_link(bench, len(readings), requests)]
    timing = (
        f"{1e6 * late.lateness_at(0.5):.0f} us late at the median, {1e6 * late.lateness_at(0.99):.0f} us at 99 %, "
        f"{late.missed} cycles missed"
    )
    right = (
        "run nothing else on this computer, or take a longer cycle"
        if late.missed > MAX_LOST_FRACTION * requests
        else ""
    )
    findings.append(CheckResult("cycles", timing, right))
    if not readings:
        return findings
    if readings[-1].stopped:
        findings.append(CheckResult("e-stop", "pressed", "release it"))
    else:
        findings.append(CheckResult("e-stop", f"released; the device {DEVICE_STATE_TEXTS[readings[-1].device]}"))
    gauge = float(np.mean([reading.supply for reading in readings])) - bench.machine.supply.ambient_pressure
    right = "shut off the air and vent the line, or set the sensor's zero" if abs(gauge) > MAX_VENTED_PRESSURE else ""
    findings.append(CheckResult("supply", f"{gauge / 1e5:+.2f} bar gauge, air off", right))
    for j, name in enumerate(bench.names):
        findings.append(_check_angle(bench, j, name, np.array([reading.angles[j] for reading in readings])))
        findings.append(_check_pressure(bench, j, name, np.array([reading.pressures[j] for reading in readings])))
    return findings


def _check_link(bench: OpenLoopRig, replies: int, requests: int) -> CheckResult:
    """Return how many replies came, and the usual reason for others; failed if over `MAX_LOST_FRACTION` are missing."""
    median = 1e6 * float(np.median(bench.transactions))
    report = f"{replies} of {requests} good replies came, {median:.0f} us at the median"
    if bench.driver.remark:
        report += f", {bench.driver.remark}"
    if not bench.failures:
        return CheckResult("link", report)
    # A refusal says more than a late reply.
    explained = [failure for failure in bench.failures if failure.right] or bench.failures
    (usual, right), count = Counter((failure.reason, failure.right) for failure in explained).most_common(1)[0]
    if usual:
        report += f"; {usual}" + (f" ({count} times)" if count < requests else "")
    right = right or "look at cable and load of the device, and at `timeout` in [interface]"
    return CheckResult("link", report, right if len(bench.failures) > MAX_LOST_FRACTION * requests else "")


def _check_angle(bench: OpenLoopRig, j: int, name: str, samples: Array) -> CheckResult:
    """Return the result of checking the angle sensor of joint j from samples at rest, rad, (samples,).

    It fails at its rail, beyond `resting_angles`, frozen, or with noise that differs from that of the description.
    """
    rail, middle, problem = bench.limits[j].rail, float(np.median(samples)), ""
    described, has_noise = sensor(bench.angle_part), bench.limits[j].angle_frozen.noisy > 0.0
    end = float(resting_angles(bench.machine)[j])
    if not rail.low < middle < rail.high:
        problem = "at its rail: it is open or shorted, look at its wires"
    elif abs(middle) > end:
        problem = f"outside the mechanical stroke, {np.degrees(end):.0f} deg either way: set its zero"
    elif has_noise and 0.0 < estimate_noise(samples) < MIN_NOISE_RATIO * described.noise:
        problem = "less noise than described, so that it would be taken for frozen at rest: describe its own"
    return _check_sensor(f"angle of {name}", f"{np.degrees(middle):.2f} deg", described, samples, problem)


def _check_pressure(bench: OpenLoopRig, j: int, name: str, samples: Array) -> CheckResult:
    """Return the result of checking the differential pressure of joint j from samples without air, Pa, (samples,).

    It fails at its rail, beyond `MAX_VENTED_PRESSURE`, frozen, or with more noise than described.
    """
    middle, problem = float(np.median(samples)), ""
    if not abs(middle) < bench.limits[j].over_pressure:
        problem = "at its rail: look at its wires"
    elif abs(middle) > MAX_VENTED_PRESSURE:
        problem = "vent the hoses, or set its zero"
    return _check_sensor(
        f"pressure of {name}", f"{middle / 1e5:+.3f} bar", sensor(bench.pressure_part), samples, problem
    )


def estimate_noise(samples: Array) -> float:
    """Return the standard deviation of the noise in samples of a joint that may sink, and meet its stop, meanwhile.

    Second differences remove motion, and the median over blocks removes a jolt. Fewer than three samples give 0.
    """
    bends = np.diff(samples, 2) / np.sqrt(6.0)
    parts = np.array_split(bends, max(len(bends) // NOISE_BLOCK_SAMPLES, 1))
    return float(np.median([np.std(part) for part in parts])) if len(bends) else 0.0


def max_noise(sensor: Sensor) -> float:
    """Return the greatest standard deviation of the noise with which a sensor passes, in the unit of the sensor."""
    return MAX_NOISE_RATIO * float((sensor.noise**2 + sensor.lsb**2 / 12.0) ** 0.5) + sensor.lsb


def _check_sensor(check_name: str, reading_text: str, sensor: Sensor, samples: Array, problem: str) -> CheckResult:
    """Return the result of a sensor's check: the given problem, or else that it is frozen or noisier than described.

    Args:
        check_name: name of the check.
        reading_text: measured value in words, with its unit.
        sensor: described noise and resolution, in the unit of the samples.
        samples: values measured at rest, (samples,).
        problem: problem found before, empty where there is none.
    """
    noise = estimate_noise(samples)
    if not problem and sensor.noise > MIN_CHANGING_NOISE * sensor.lsb and np.ptp(samples) == 0.0:
        problem = "it repeats itself: its converter is frozen, or the wire is off"
    elif not problem and noise > max_noise(sensor):
        problem = "much noise: look at its screen and ground"
    return CheckResult(check_name, f"{reading_text}, noise {noise / sensor.lsb:.1f} counts", problem)


def check_in_subprocess(
    machine: Machine, driver: Callable[[], Driver], *, air: bool, tell: Callable[[str], object],
    minded: Callable[[], bool] = lambda: True,
) -> list[CheckResult]:  # fmt: skip
    """Check a rig as `check_rig` does, in a subprocess, and return the results; it blocks until then.

    Args:
        machine: description of the rig.
        driver: factory of its driver, called in the subprocess; it must be picklable.
        air: whether to check with air, too: joints move.
        tell: called with the name of each step.
        minded: polled every 50 ms; once it returns False, the check is broken off and the air vented.

    Raises:
        LayflatError: no fitting device answers, the check was broken off, or its process ended without a result.
    """
    mine, its = Pipe()
    process = start_process(_run_check, (machine, driver, air, its), "layflat-check")
    its.close()
    try:
        while minded():
            if mine.poll(POLL_INTERVAL):
                kind, what = mine.recv()
                if kind == "found":
                    return list(what)
                if kind == "failed":
                    raise LayflatError(what)
                tell(what)
        raise LayflatError("the check was broken off, and the air vented")
    except (EOFError, OSError):
        process.join(0.1)  # so that its status is known
        what = f"the check's process ended without a result (status {process.exitcode}); check the rig again"
        raise LayflatError(what) from None
    finally:
        process.terminate()
        end_process(process, VENT_TIMEOUT)


def _run_check(machine: Machine, driver: Callable[[], Driver], air: bool, pipe: Connection) -> None:
    """Check the rig in this process, with real-time priority where granted, and send progress and result into a pipe.

    Messages are ("doing", step), then ("found", results) or ("failed", message). SIGTERM vents the hoses and ends it.
    """
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # so that the air is vented
    gc.freeze()
    gc.disable()  # a collection takes many cycles
    with suppress(OSError, AttributeError):
        set_fifo_priority()
    try:
        said: tuple[str, Any] = (
            "found",
            check_rig(machine, driver(), MonotonicClock(), air=air, tell=lambda text: pipe.send(("doing", text))),
        )
    except LayflatError as error:
        said = "failed", str(error)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # it ends by itself, and Python's own end must not be broken off
    with suppress(OSError):
        pipe.send(said)
