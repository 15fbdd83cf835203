"""Dither: what it moves, what it is needed for, and the averaging that hides it (section 3)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.control.controller import start, step
from layflat.control.gains import Measurement
from layflat.experiments.bench import Bench
from layflat.experiments.claim import Claim
from layflat.experiments.kernels import sweep_spool
from layflat.machine import Machine, parameters
from layflat.machine.model import SpoolValve
from layflat.sim import rollout

SETTLED = 1.0
"""Ripple is measured from this time on, s."""
SMALL_SIGNAL = 0.05
"""Commands up to this are small, share of full opening."""
HIGH_FREQUENCY = 400.0
"""A dither too fast for the spool, Hz."""


@dataclass(frozen=True)
class ValveSweep:
    """Mean net opening (to supply less to exhaust, of one hose) against a slowly swept command, on both ways."""

    command: NDArray[np.float64]
    up: NDArray[np.float64]
    down: NDArray[np.float64]

    @property
    def hysteresis(self) -> float:
        """Greatest difference between both ways, share of full opening."""
        return float(np.max(np.abs(self.up - self.down)))

    @property
    def gain(self) -> float:
        """Steepest slope of opening against command for small commands, where a valve works that holds a joint."""
        return float(np.max(np.gradient(self.up, self.command)[np.abs(self.command) <= SMALL_SIGNAL]))


@dataclass(frozen=True)
class Dither:
    """Ripple amplitudes by joint with and without brake; valve sweeps; response of the averaged signal."""

    angle_free: dict[str, float]
    angle_braked: dict[str, float]
    pressure_free: dict[str, float]
    pressure_braked: dict[str, float]
    without: ValveSweep
    normal: ValveSweep
    fast: ValveSweep
    frequency: NDArray[np.float64]
    response: NDArray[np.float64]
    suppression: float
    delay: float


def amplitude_at(time: NDArray[np.float64], signal: NDArray[np.float64], frequency: float) -> float:
    """Amplitude of one frequency in a signal, over a whole number of its periods."""
    turns = np.exp(-2j * pi * frequency * time)
    return float(2.0 * np.abs(np.mean((signal - signal.mean()) * turns)))


def ripple(machine: Machine, brake: float, frequency: float) -> tuple[dict[str, float], dict[str, float]]:
    """Amplitudes at a frequency (Hz) of angle (rad) and differential pressure (Pa), valve command centred."""
    run = rollout(machine, opening=0.0, brake=brake, duration=SETTLED + 1.0, records=10, noise=False)
    part = run.isel(time=slice(0, -1)).sel(time=slice(SETTLED - 1e-9, None))
    time = part["time"].to_numpy()
    difference = part["pressure_a"] - part["pressure_b"]
    angle = {j: amplitude_at(time, part["angle"].sel(joint=j).to_numpy(), frequency) for j in machine.joints}
    pressure = {j: amplitude_at(time, difference.sel(joint=j).to_numpy(), frequency) for j in machine.joints}
    return angle, pressure


def sweep_valve(valve: SpoolValve, amplitude: float, frequency: float) -> ValveSweep:
    """Sweep a valve's command slowly up and down over a fifth of its stroke."""
    law = parameters.spool_valve(valve)
    command = np.linspace(-0.2, 0.2, 81)
    both = np.concatenate([command, command[::-1]])
    lap = np.concatenate([both, both])
    opening = sweep_spool(law, lap, amplitude, frequency, 1e-4, 800)
    return ValveSweep(command, opening[162:243], opening[243:][::-1])


def frequency_response(frequency: NDArray[np.float64], cycle: float) -> NDArray[np.complex128]:
    """Response of the controller's average to a sampled sine, measured by feeding it one."""
    found = []
    for f in frequency:
        t = cycle * np.arange(4000)
        x = np.exp(2j * pi * f * t)
        y = 0.25 * (x[3:] + x[2:-1] + x[1:-2] + x[:-3])
        found.append(np.mean(y / x[3:]))
    return np.array(found)


def perform(bench: Bench) -> Dither:
    """Measure ripple with and without brake, sweep the valve, and probe the average."""
    arm = bench.arm
    dither = bench.valve.dither
    angle_free, pressure_free = ripple(arm, 0.0, dither.frequency)
    angle_braked, pressure_braked = ripple(arm, bench.brake, dither.frequency)
    frequency = np.linspace(0.5, 100.0, 400)
    response = frequency_response(frequency, arm.cycle)
    suppression, delay = _average(bench)
    return Dither(
        angle_free,
        angle_braked,
        pressure_free,
        pressure_braked,
        sweep_valve(bench.valve, 0.0, dither.frequency),
        sweep_valve(bench.valve, dither.amplitude, dither.frequency),
        sweep_valve(bench.valve, dither.amplitude, HIGH_FREQUENCY),
        frequency,
        np.abs(response),
        suppression,
        delay,
    )


def _average(bench: Bench) -> tuple[float, float]:
    """Suppression of the dither's frequency (dB) and delay (s) of the angle that the controller uses."""
    gains, cycle = parameters.gains(bench.arm, "small"), bench.arm.cycle

    def used(signal: NDArray[Any]) -> NDArray[np.float64]:
        memory = start(Measurement(float(signal[0]), 0.0, cycle))
        out = np.empty_like(signal)
        for i, value in enumerate(signal):
            memory, _, status = step(gains, memory, Measurement(float(value), 0.0, cycle), 0.0)
            out[i] = status.angle
        return out

    t = cycle * np.arange(200)
    swing = used(np.sin(2 * pi * bench.valve.dither.frequency * t + 0.3))[20:]
    suppression = -20.0 * np.log10(max(float(np.abs(swing).max()), 1e-12))
    ramp = used(t)
    return float(suppression), float(np.mean((t - ramp)[20:]))


def claims(found: Dither) -> list[Claim]:
    """What the paper says of dither."""
    return [_motion(found), _need(found), _averaging(found)]


def _motion(found: Dither) -> Claim:
    joints = list(found.angle_free)
    smaller = min(found.angle_free[j] / max(found.angle_braked[j], 1e-15) for j in joints)
    kept = min(100.0 * found.pressure_braked[j] / max(found.pressure_free[j], 1e-15) for j in joints)
    return Claim(
        "dither-motion",
        "3",
        "unbraked joints follow the 50 Hz dither; the brake stops that, but the pressure still ripples",
        {
            "ripple without brake (deg)": float(np.degrees(max(found.angle_free.values()))),
            "times smaller with brake": min(smaller, 1e6),
            "pressure ripple kept (%)": kept,
        },
        "as named",
        min(found.angle_free.values()) > 0.0 and smaller >= 10.0 and kept >= 70.0,
        "angle ripple at least 10 times smaller, pressure ripple at least 70 % kept",
    )


def _need(found: Dither) -> Claim:
    return Claim(
        "dither-need",
        "3",
        "without dither friction gives the valve hysteresis; a faster dither makes it more of an on/off valve",
        {
            "hysteresis without": found.without.hysteresis,
            "hysteresis at 50 Hz": found.normal.hysteresis,
            "gain at 50 Hz": found.normal.gain,
            "gain when too fast": found.fast.gain,
        },
        "share of full opening; opening per command",
        found.without.hysteresis >= 5.0 * found.normal.hysteresis and found.fast.gain > 1.05 * found.normal.gain,
        "hysteresis at least 5 times smaller at 50 Hz; small-signal gain rises when dither no longer moves the spool",
    )


def _averaging(found: Dither) -> Claim:
    return Claim(
        "averaging",
        "3",
        "sampling over the full 20 ms avoids aliasing and costs delay",
        {"suppression (dB)": found.suppression, "delay (ms)": 1000.0 * found.delay},
        "as named",
        found.suppression >= 40.0 and 7.5 - 1e-6 <= 1000.0 * found.delay <= 10.0,
        "50 Hz suppressed by at least 40 dB; delay 7.5 to 10 ms",
    )
