"""What can be fitted of a regulated joint, and how far around the description.

The torque per pressure is held: pressures and angles identify all torques and volumes only in proportion to it; the
supply is known from its gauge.
"""

from __future__ import annotations

from collections.abc import Collection

from layflat.identify.benches.regulated.description import RegulatedJointBench, least_volume
from layflat.identify.unknown import Unknown

GAIN, OFFSET, DELAY = 1.5, 100e3, 0.15
"""Farthest gain (either way), offset (Pa) and delay (s) of a valve."""

FAR, FARTHER = 20.0, 50.0
"""Bounds are the guess over and times this: of what a person knows within about a factor of four, and of all else."""

LOADS = 400e3
"""Load torques are searched up to this pressure, Pa, on the torque per pressure."""

BEYOND = 0.3
"""Stops are searched this far beyond the reading, as a share of it."""

STEPS = "changes of the set-point, up and down"
LARGE = "large steps of the set-point"
MOVES = "moves of different size and speed"
HOLDS = "moves that begin from rest at several angles, both ways"
RESTS = "rests at several set-points"
AT_STOP = "moves that leave the end of the reading"

BLOCKS = ("valve", "gas", "motion")


def unknowns_of(
    bench: RegulatedJointBench, blocks: Collection[str], at_lower: bool, at_upper: bool
) -> tuple[Unknown, ...]:
    """Unknowns of some blocks; guesses are the values of the description.

    Args:
        bench: the description.
        blocks: of `BLOCKS`.
        at_lower: whether the reading comes to its lower end; if not, the stop there is not searched.
        at_upper: the same of its upper end.
    """
    found = {"valve": _valve(bench), "gas": _gas(bench), "motion": _motion(bench, at_lower, at_upper)}
    return tuple(unknown for block in BLOCKS if block in blocks for unknown in found[block])


def _by_factor(path: str, unit: str, guess: float, factor: float, excitation: str) -> Unknown:
    return Unknown(path, unit, guess, guess / factor, guess * factor, True, excitation)


def _evenly(path: str, unit: str, guess: float, reach: float, excitation: str) -> Unknown:
    return Unknown(path, unit, guess, guess - reach, guess + reach, False, excitation)


def _valve(bench: RegulatedJointBench) -> list[Unknown]:
    valve, C = bench.valve, "m^3/s/Pa"
    return [
        _by_factor("valve.gain", "1", valve.gain, GAIN, RESTS),
        _evenly("valve.offset", "Pa", valve.offset, OFFSET, RESTS),
        Unknown("valve.delay", "s", valve.delay, 0.0, max(DELAY, 2.0 * valve.delay), False, STEPS, floor=True),
        _by_factor("valve.lag", "s", valve.lag, FAR, STEPS),
        _by_factor("valve.conductance_in", C, valve.conductance_in, FARTHER, f"{LARGE}, upwards"),
        _by_factor("valve.conductance_out", C, valve.conductance_out, FARTHER, f"{LARGE}, downwards"),
        _by_factor("valve.band_in", "Pa", valve.band_in, FAR, f"{STEPS}, of different size"),
        _by_factor("valve.band_out", "Pa", valve.band_out, FAR, f"{STEPS}, of different size"),
    ]


def _gas(bench: RegulatedJointBench) -> list[Unknown]:
    volume = bench.chamber.volume
    low = min(volume, max(volume / FAR, 1.02 * _widest_volume(bench)))
    return [
        Unknown("chamber.volume", "m^3", volume, low, volume * FAR, True, "fast moves"),
        _by_factor("chamber.wall_conductance", "W/K", bench.chamber.wall_conductance, FARTHER, LARGE),
    ]


def _motion(bench: RegulatedJointBench, at_lower: bool, at_upper: bool) -> list[Unknown]:
    load, friction, stroke = bench.load, bench.friction, bench.stroke
    most, half = LOADS * bench.chamber.torque_per_pressure, 0.5 * stroke.reading
    reach = 2.0 * BEYOND * half
    low, high = min(-half - reach, stroke.lower_stop), max(half + reach, stroke.upper_stop)
    return [
        _by_factor("load.inertia", "kg*m^2", load.inertia, FARTHER, "moves that start and stop fast"),
        _by_factor("load.damping", "N*m*s/rad", load.damping, FARTHER, MOVES),
        _evenly("load.torque", "N*m", load.torque, most, HOLDS),
        _evenly("load.stiffness", "N*m/rad", load.stiffness, most / half, HOLDS),
        _by_factor("friction.lower_end", "N*m", friction.lower_end, FARTHER, HOLDS),
        _by_factor("friction.upper_end", "N*m", friction.upper_end, FARTHER, HOLDS),
        _by_factor("friction.lag", "s", friction.lag, FAR, "rests of different length, followed by moves"),
        *[Unknown("stroke.lower_stop", "rad", stroke.lower_stop, low, -half, False, AT_STOP, floor=True)] * at_lower,
        *[Unknown("stroke.upper_stop", "rad", stroke.upper_stop, half, high, False, AT_STOP, floor=True)] * at_upper,
    ]


def _widest_volume(bench: RegulatedJointBench) -> float:
    """Least volume that leaves some air in a chamber wherever the stops are searched, m3."""
    reach = (0.5 + BEYOND) * bench.stroke.reading
    return max(least_volume(bench), bench.chamber.torque_per_pressure * reach)
