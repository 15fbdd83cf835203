"""What is to be found of a regulated joint, and where to look for it."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from layflat.identify.unknown import Unknown
from layflat.machine.rigs.regulated import RegulatedRig, least_volume

BLOCKS: dict[str, tuple[str, ...]] = {
    "valve": (
        "valve.gain",
        "valve.offset",
        "valve.delay",
        "valve.lag",
        "valve.conductance_in",
        "valve.conductance_out",
        "valve.band_in",
        "valve.band_out",
    ),
    "gas": ("chamber.volume", "chamber.wall_conductance"),
    "motion": (
        "load.inertia",
        "load.damping",
        "load.torque",
        "load.stiffness",
        "friction.lower_end",
        "friction.upper_end",
        "friction.lag",
        "stroke.lower_stop",
        "stroke.upper_stop",
    ),
}
"""Blocks of unknowns. The torque per pressure is held: pressures and angles tell all torques and volumes only by it;
the supply is known from its gauge."""

GAIN, OFFSET, DELAY = 1.5, 100e3, 0.15
"""Farthest gain (either way), offset (Pa) and delay (s) of a valve."""

FAR, FARTHER = 20.0, 50.0
"""Bounds are the guess over and times this: of what a person knows within about a factor of four, and of all else."""

LOADS = 400e3
"""Load torques are looked for up to this pressure, Pa, on the torque per pressure."""

BEYOND = 0.3
"""Stops are looked for this far beyond the reading, as a share of it."""

STEPS = "changes of the set-point, up and down"
LARGE = "large steps of the set-point"
MOVES = "moves of different size and speed"
HOLDS = "moves that begin from rest at several angles, both ways"


def unknowns_of(rig: RegulatedRig, blocks: Collection[str], ends: Sequence[bool]) -> tuple[Unknown, ...]:
    """Unknowns of some blocks; guesses are the values of the description.

    Args:
        rig: the description.
        blocks: of `BLOCKS`.
        ends: whether the reading comes to its lower and to its upper end; if not, that stop is not looked for.
    """
    found = {one.path: one for one in (*_valve(rig), *_gas(rig), *_motion(rig, ends))}
    return tuple(found[path] for block in BLOCKS if block in blocks for path in BLOCKS[block] if path in found)


def _by_factor(path: str, unit: str, guess: float, factor: float, excitation: str) -> Unknown:
    return Unknown(path, unit, guess, guess / factor, guess * factor, True, excitation)


def _valve(rig: RegulatedRig) -> list[Unknown]:
    valve = rig.valve
    C = "m^3/s/Pa"
    return [
        _by_factor("valve.gain", "1", valve.gain, GAIN, "rests at several set-points"),
        _evenly("valve.offset", "Pa", valve.offset, OFFSET, "rests at several set-points"),
        Unknown("valve.delay", "s", valve.delay, 0.0, max(DELAY, 2.0 * valve.delay), False, STEPS, floor=True),
        _by_factor("valve.lag", "s", valve.lag, FAR, STEPS),
        _by_factor("valve.conductance_in", C, valve.conductance_in, FARTHER, f"{LARGE}, upwards"),
        _by_factor("valve.conductance_out", C, valve.conductance_out, FARTHER, f"{LARGE}, downwards"),
        _by_factor("valve.band_in", "Pa", valve.band_in, FAR, f"{STEPS}, of different size"),
        _by_factor("valve.band_out", "Pa", valve.band_out, FAR, f"{STEPS}, of different size"),
    ]


def _gas(rig: RegulatedRig) -> list[Unknown]:
    chamber = rig.chamber
    low = max(chamber.volume / FAR, 1.02 * _widest_volume(rig))
    return [
        Unknown(
            "chamber.volume", "m^3", chamber.volume, min(low, chamber.volume), chamber.volume * FAR, True, "fast moves"
        ),
        _by_factor("chamber.wall_conductance", "W/K", chamber.wall_conductance, FARTHER, LARGE),
    ]


def _motion(rig: RegulatedRig, ends: Sequence[bool]) -> list[Unknown]:
    load, friction, stroke = rig.load, rig.friction, rig.stroke
    most, half = LOADS * rig.chamber.torque_per_pressure, 0.5 * stroke.reading
    found = [
        _by_factor("load.inertia", "kg*m^2", load.inertia, FARTHER, "moves that start and stop fast"),
        _by_factor("load.damping", "N*m*s/rad", load.damping, FARTHER, MOVES),
        _evenly("load.torque", "N*m", load.torque, most, HOLDS),
        _evenly("load.stiffness", "N*m/rad", load.stiffness, most / half, HOLDS),
        _by_factor("friction.lower_end", "N*m", friction.lower_end, FARTHER, HOLDS),
        _by_factor("friction.upper_end", "N*m", friction.upper_end, FARTHER, HOLDS),
        _by_factor("friction.lag", "s", friction.lag, FAR, "rests of different length, followed by moves"),
    ]
    reach = 2.0 * BEYOND * half
    told = "moves that leave the end of the reading"
    if ends[0]:
        low = min(-half - reach, stroke.lower_stop)
        found.append(Unknown("stroke.lower_stop", "rad", stroke.lower_stop, low, -half, False, told, floor=True))
    if ends[1]:
        high = max(half + reach, stroke.upper_stop)
        found.append(Unknown("stroke.upper_stop", "rad", stroke.upper_stop, half, high, False, told, floor=True))
    return found


def _evenly(path: str, unit: str, guess: float, reach: float, excitation: str) -> Unknown:
    return Unknown(path, unit, guess, guess - reach, guess + reach, False, excitation)


def _widest_volume(rig: RegulatedRig) -> float:
    """Least volume that leaves some air in a chamber wherever the stops are looked for, m3."""
    reach = (0.5 + BEYOND) * rig.stroke.reading
    return max(least_volume(rig), rig.chamber.torque_per_pressure * reach)
