"""Dither: what it moves, what it is needed for, and the averaging that hides it (section 3)."""

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.control.paper.law import step_joint, wake_joint
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.experiments.kernels import sweep_spool
from layflat.machine import Machine, parameters
from layflat.physics.valves import VALVES
from layflat.physics.valves.spool import SpoolValvePart
from layflat.sim import rollout

SETTLED = 1.0  # ripple is measured from this time on, s
SMALL_SIGNAL = 0.05  # commands up to this are small, share of full opening
FAR, CLOSELY = 0.2, 0.005  # how far commands are swept, and by what
SWEPT_BY = (1e-4, 800)  # step of the spool, s, and steps at each command
HIGH_FREQUENCY = 400.0  # a dither too fast for the spool, Hz
OPENING = "of full opening"


@dataclass(frozen=True)
class ValveSweep:
    """Mean net opening (to supply less to exhaust, of one hose) against a slowly swept command, on both ways."""

    command: Array
    up: Array
    down: Array

    @property
    def hysteresis(self) -> float:
        """Greatest difference between both ways, share of full opening."""
        return float(np.max(np.abs(self.up - self.down)))

    @property
    def gain(self) -> float:
        """Steepest slope of opening against command for small commands, where a valve works that holds a joint."""
        return _steepest(self.up, self.command)


def _steepest(opening: Array, command: Array) -> float:
    return float(np.max(np.gradient(opening, command)[np.abs(command) <= SMALL_SIGNAL + 1e-9]))


def amplitude_at(time: Array, signal: Array, frequency: float) -> float:
    """Return the amplitude of one frequency in a signal, over a whole number of its periods."""
    rotation = np.exp(-2j * pi * frequency * time)
    return float(2.0 * np.abs(np.mean((signal - signal.mean()) * rotation)))


def ripple(machine: Machine, brake: float, frequency: float) -> tuple[dict[str, float], dict[str, float]]:
    """Return amplitudes at a frequency (Hz) of angle (rad) and differential pressure (Pa), the valve centred."""
    run = rollout(machine, opening=0.0, brake=brake, duration=SETTLED + 1.0, records=10, noise=False)
    part = run.isel(time=slice(0, -1)).sel(time=slice(SETTLED - 1e-9, None))
    time = part["time"].to_numpy()
    difference = part["pressure_a"] - part["pressure_b"]
    angle = {j: amplitude_at(time, part["angle"].sel(joint=j).to_numpy(), frequency) for j in machine.joints}
    pressure = {j: amplitude_at(time, difference.sel(joint=j).to_numpy(), frequency) for j in machine.joints}
    return angle, pressure


def sweep_valve(valve: SpoolValvePart, amplitude: float, frequency: float) -> ValveSweep:
    """Sweep a valve's command slowly up and down over a fifth of its stroke."""
    law = VALVES.parameters(valve)
    command = np.linspace(-FAR, FAR, 1 + round(2.0 * FAR / CLOSELY))
    both = np.concatenate([command, command[::-1]])
    lap = np.concatenate([both, both])
    opening = sweep_spool(law, lap, amplitude, frequency, *SWEPT_BY)
    up, down = np.split(opening[len(both) :], 2)
    return ValveSweep(command, up, down[::-1])


def small_gain(valve: SpoolValvePart, amplitude: float, frequency: float) -> float:
    """Return the gain of a valve alone (`ValveSweep.gain`), swept where it counts."""
    # Friction of the spool holds it below where it is going, so it comes from below.
    command = np.arange(-2.0 * SMALL_SIGNAL, SMALL_SIGNAL + 1.5 * CLOSELY, CLOSELY)
    opening = sweep_spool(VALVES.parameters(valve), np.append(-FAR, command), amplitude, frequency, *SWEPT_BY)
    return _steepest(opening[1:], command)


def frequency_response(frequency: Array, cycle: float) -> Array:
    """Return the gain of the controller's average, the mean of four samples that are a cycle (s) apart."""
    return np.asarray(np.abs(np.mean(np.exp(-2j * pi * cycle * np.outer(np.arange(4), frequency)), axis=0)))


def followed(gains: Any, cycle: float, signal: NDArray[Any]) -> Array:
    """Return the angle that a controller uses where its sensor gives `signal`."""
    memory = wake_joint(gains, float(signal[0]), 0.0)
    out = np.empty_like(signal)
    for i, value in enumerate(signal):
        memory, _, report = step_joint(gains, memory, float(value), 0.0, 0.0, cycle)
        out[i] = report.averaged_angle
    return out


class Dither(Experiment):
    """Ripple with and without brake; sweeps of the valve; response of the averaged signal."""

    frequency = np.linspace(0.5, 100.0, 400)  # at which the averaged signal is probed, Hz

    @cached_property
    def response(self) -> Array:
        """Gain of the average at these frequencies."""
        return frequency_response(self.frequency, self.bench.arm.cycle)

    @cached_property
    def sweeps(self) -> dict[str, ValveSweep]:
        """The valve without dither, with its own, and with one that is too fast."""
        valve, own = self.bench.valve, self.bench.valve.dither
        return {
            "without": sweep_valve(valve, 0.0, own.frequency),
            "normal": sweep_valve(valve, own.amplitude, own.frequency),
            "fast": sweep_valve(valve, own.amplitude, HIGH_FREQUENCY),
        }

    @claim("dither-motion")
    def motion(self) -> Evaluated:
        """Compare the ripple of angle and pressure with and without brake."""
        arm, at = self.bench.arm, self.bench.valve.dither.frequency
        (angle, pressure), (angle_braked, pressure_braked) = (ripple(arm, b, at) for b in (0.0, self.bench.brake))
        smaller = min(angle[j] / max(angle_braked[j], 1e-15) for j in angle)
        kept = min(100.0 * pressure_braked[j] / max(pressure[j], 1e-15) for j in pressure)
        return [
            Quantity("ripple without brake", float(np.degrees(max(angle.values()))), "deg", "visible"),
            Quantity("times smaller with brake", min(smaller, 1e6), paper="stopped"),
            Quantity("pressure ripple kept", kept, "%", "kept"),
        ], min(angle.values()) > 0.0 and smaller >= 10.0 and kept >= 70.0

    @claim("dither-need")
    def need(self) -> Evaluated:
        """Compare the valve's sweeps."""
        without, normal, fast = (self.sweeps[name] for name in ("without", "normal", "fast"))
        return [
            Quantity("hysteresis without", without.hysteresis, OPENING, "some"),
            Quantity("hysteresis at 50 Hz", normal.hysteresis, OPENING, "none"),
            Quantity("gain at 50 Hz", normal.gain),
            Quantity("gain when too fast", fast.gain, paper="greater"),
        ], without.hysteresis >= 5.0 * normal.hysteresis and fast.gain > 1.05 * normal.gain

    @claim("averaging")
    def averaging(self) -> Evaluated:
        """Probe the angle that the controller uses with the dither's frequency and with a ramp."""
        gains, cycle = parameters.control(self.bench.arm).joints[-1], self.bench.arm.cycle
        t = cycle * np.arange(200)
        swing = followed(gains, cycle, np.sin(2 * pi * self.bench.valve.dither.frequency * t + 0.3))[20:]
        suppression = float(-20.0 * np.log10(max(float(np.abs(swing).max()), 1e-12)))
        delay = 1000.0 * float(np.mean((t - followed(gains, cycle, t))[20:]))
        return [
            Quantity("suppression", suppression, "dB", "avoids aliasing"),
            Quantity("delay", delay, "ms", "costs delay"),
        ], suppression >= 40.0 and 7.5 - 1e-6 <= delay <= 10.0
