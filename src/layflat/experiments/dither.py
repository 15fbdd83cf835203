"""Dither: the ripple that it causes, the valve's need of it, and the averaging that suppresses it (section 3)."""

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.control.paper.law import step_joint, wake_joint
from layflat.experiments.claim import ClaimQuantity, Evaluation, Experiment, claim
from layflat.experiments.kernels import sweep_spool
from layflat.machine import Machine, parameters
from layflat.physics.valves import VALVE_KINDS
from layflat.physics.valves.spool import SpoolValvePart
from layflat.sim import rollout

RIPPLE_START = 1.0  # time from which ripple is measured, s
SMALL_SIGNAL = 0.05  # upper limit of small commands, fraction of full opening
SWEEP_RANGE, SWEEP_INCREMENT = 0.2, 0.005  # of swept commands, fractions of full opening
SWEEP_STEPPING = (1e-4, 800)  # integration step of the spool, s, and steps at each command
HIGH_FREQUENCY = 400.0  # a dither too fast for the spool, Hz
OPENING_UNIT = "of full opening"


@dataclass(frozen=True)
class ValveSweep:
    """Mean net opening (to supply less to exhaust, of one hose) over a slowly swept command, rising and falling."""

    command: Array
    up: Array
    down: Array

    @property
    def hysteresis(self) -> float:
        """Greatest difference between rising and falling sweep, fraction of full opening."""
        return float(np.max(np.abs(self.up - self.down)))

    @property
    def gain(self) -> float:
        """Greatest slope of opening over small commands, which is where a valve that holds a joint works."""
        return _max_small_signal_slope(self.up, self.command)


def _max_small_signal_slope(opening: Array, command: Array) -> float:
    return float(np.max(np.gradient(opening, command)[np.abs(command) <= SMALL_SIGNAL + 1e-9]))


def amplitude_at(time: Array, signal: Array, frequency: float) -> float:
    """Return the amplitude of one frequency in a signal, in the signal's unit.

    Args:
        time: s, over a whole number of periods.
        signal: samples at these times.
        frequency: Hz.
    """
    rotation = np.exp(-2j * pi * frequency * time)
    return float(2.0 * np.abs(np.mean((signal - signal.mean()) * rotation)))


def ripple_amplitudes(machine: Machine, brake: float, frequency: float) -> tuple[dict[str, float], dict[str, float]]:
    """Return amplitudes at one frequency of angle (rad) and differential pressure (Pa) by joint, the valve centred.

    Args:
        machine: machine that is simulated.
        brake: torque of the brakes, as a fraction of their full torque.
        frequency: Hz.
    """
    run = rollout(machine, opening=0.0, brake=brake, duration=RIPPLE_START + 1.0, records=10, noise=False)
    part = run.isel(time=slice(0, -1)).sel(time=slice(RIPPLE_START - 1e-9, None))
    time = part["time"].to_numpy()
    difference = part["pressure_a"] - part["pressure_b"]
    angle = {j: amplitude_at(time, part["angle"].sel(joint=j).to_numpy(), frequency) for j in machine.joints}
    pressure = {j: amplitude_at(time, difference.sel(joint=j).to_numpy(), frequency) for j in machine.joints}
    return angle, pressure


def sweep_valve(valve: SpoolValvePart, amplitude: float, frequency: float) -> ValveSweep:
    """Sweep a valve's command slowly up and down, to a fifth of its stroke each way.

    Args:
        valve: spool valve.
        amplitude: amplitude of the dither, fraction of full opening.
        frequency: frequency of the dither, Hz.
    """
    law = VALVE_KINDS.parameters(valve)
    command = np.linspace(-SWEEP_RANGE, SWEEP_RANGE, 1 + round(2.0 * SWEEP_RANGE / SWEEP_INCREMENT))
    both = np.concatenate([command, command[::-1]])
    lap = np.concatenate([both, both])
    opening = np.empty_like(lap)
    sweep_spool(law, lap, amplitude, frequency, *SWEEP_STEPPING, opening)
    up, down = np.split(opening[len(both) :], 2)
    return ValveSweep(command, up, down[::-1])


def small_signal_gain(valve: SpoolValvePart, amplitude: float, frequency: float) -> float:
    """Return a valve's gain (`ValveSweep.gain`) from a sweep of small commands only.

    Args:
        valve: spool valve.
        amplitude: amplitude of the dither, fraction of full opening.
        frequency: frequency of the dither, Hz.
    """
    # Friction holds the spool back, so the sweep begins below the range that counts.
    command = np.arange(-2.0 * SMALL_SIGNAL, SMALL_SIGNAL + 1.5 * SWEEP_INCREMENT, SWEEP_INCREMENT)
    swept = np.append(-SWEEP_RANGE, command)
    opening = np.empty_like(swept)
    sweep_spool(VALVE_KINDS.parameters(valve), swept, amplitude, frequency, *SWEEP_STEPPING, opening)
    return _max_small_signal_slope(opening[1:], command)


def frequency_response(frequency: Array, cycle: float) -> Array:
    """Return the gain, at frequencies (Hz), of the controller's mean of four samples that are a cycle (s) apart."""
    return np.asarray(np.abs(np.mean(np.exp(-2j * pi * cycle * np.outer(np.arange(4), frequency)), axis=0)))


def averaged_angle(gains: Any, cycle: float, signal: NDArray[Any]) -> Array:
    """Return the averaged angle that a joint's control law uses, (n,) rad.

    Args:
        gains: gains of the joint.
        cycle: period of control, s.
        signal: angle that its sensor measures each cycle, (n,) rad.
    """
    memory = wake_joint(gains, float(signal[0]), 0.0)
    out = np.empty_like(signal)
    for i, value in enumerate(signal):
        memory, _, report = step_joint(gains, memory, float(value), 0.0, 0.0, cycle)
        out[i] = report.averaged_angle
    return out


class DitherExperiment(Experiment):
    """Ripple with and without brake; sweeps of the valve; response of the averaged signal."""

    frequency = np.linspace(0.5, 100.0, 400)  # of the response, Hz

    @cached_property
    def response(self) -> Array:
        """Gain of the controller's average at `frequency`."""
        return frequency_response(self.frequency, self.bench.arm.cycle)

    @cached_property
    def sweeps(self) -> dict[str, ValveSweep]:
        """Sweeps of the valve: "without" dither, with its own ("normal"), with one too fast for its spool ("fast")."""
        valve, dither = self.bench.valve, self.bench.valve.dither
        return {
            "without": sweep_valve(valve, 0.0, dither.frequency),
            "normal": sweep_valve(valve, dither.amplitude, dither.frequency),
            "fast": sweep_valve(valve, dither.amplitude, HIGH_FREQUENCY),
        }

    @claim("dither-motion")
    def motion(self) -> Evaluation:
        """Compare the ripple of angle and pressure with and without brake; the joint that differs least counts."""
        arm, frequency = self.bench.arm, self.bench.valve.dither.frequency
        (angle, pressure), (angle_braked, pressure_braked) = (
            ripple_amplitudes(arm, b, frequency) for b in (0.0, self.bench.brake)
        )
        smaller = min(angle[j] / max(angle_braked[j], 1e-15) for j in angle)
        kept = min(100.0 * pressure_braked[j] / max(pressure[j], 1e-15) for j in pressure)
        return [
            ClaimQuantity("ripple without brake", float(np.degrees(max(angle.values()))), "deg", "visible"),
            ClaimQuantity("times smaller with brake", min(smaller, 1e6), paper="stopped"),
            ClaimQuantity("pressure ripple kept", kept, "%", "kept"),
        ], min(angle.values()) > 0.0 and smaller >= 10.0 and kept >= 70.0

    @claim("dither-need")
    def need(self) -> Evaluation:
        """Compare the valve's sweeps without dither, with its own, and with one that is too fast."""
        without, normal, fast = (self.sweeps[name] for name in ("without", "normal", "fast"))
        return [
            ClaimQuantity("hysteresis without", without.hysteresis, OPENING_UNIT, "some"),
            ClaimQuantity("hysteresis at 50 Hz", normal.hysteresis, OPENING_UNIT, "none"),
            ClaimQuantity("gain at 50 Hz", normal.gain),
            ClaimQuantity("gain when too fast", fast.gain, paper="greater"),
        ], without.hysteresis >= 5.0 * normal.hysteresis and fast.gain > 1.05 * normal.gain

    @claim("averaging")
    def averaging(self) -> Evaluation:
        """Measure the averaged angle's gain at the dither's frequency, and its delay on a ramp."""
        gains, cycle = parameters.control(self.bench.arm).joints[-1], self.bench.arm.cycle
        t = cycle * np.arange(200)
        oscillation = averaged_angle(gains, cycle, np.sin(2 * pi * self.bench.valve.dither.frequency * t + 0.3))[20:]
        suppression = float(-20.0 * np.log10(max(float(np.abs(oscillation).max()), 1e-12)))
        delay = 1000.0 * float(np.mean((t - averaged_angle(gains, cycle, t))[20:]))
        return [
            ClaimQuantity("suppression", suppression, "dB", "avoids aliasing"),
            ClaimQuantity("delay", delay, "ms", "costs delay"),
        ], suppression >= 40.0 and 7.5 - 1e-6 <= delay <= 10.0
