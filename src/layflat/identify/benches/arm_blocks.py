"""What can be found of a machine from motion and pressures, block by block, and how far around the description."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.identify.unknown import Unknown
from layflat.machine import Machine
from layflat.machine.model import SwitchingValves
from layflat.physics.delay import LONGEST

Reach = Callable[[Machine, float], tuple[float, float, bool]]
"""Least and greatest value (SI) from the machine and what it says now, and whether the search goes by the logarithm."""


def times(factor: float, usual: float = 1.0, most: float = float("inf")) -> Reach:
    """A factor both ways; where the machine says zero, from there to what is `usual`."""

    def reach(_: Machine, guess: float) -> tuple[float, float, bool]:
        return (guess / factor, min(guess * factor, most), True) if guess > 0.0 else (0.0, usual, False)

    return reach


def plainly(factor: float, usual: float) -> Reach:
    """As `times`, but not by the logarithm: what adds to something that is known changes nothing by factors."""

    def reach(_: Machine, guess: float) -> tuple[float, float, bool]:
        return (guess / factor, guess * factor, False) if guess > 0.0 else (0.0, usual, False)

    return reach


def between(low: float, high: float) -> Reach:
    """These ends, or the machine's own value where that lies beyond."""
    return lambda _, guess: (min(low, guess), max(high, guess), False)


def up_to(most: Callable[[Machine, float], float]) -> Reach:
    """From zero on."""
    return lambda machine, guess: (0.0, max(most(machine, guess), guess), False)


def around(reach: Callable[[Machine], float]) -> Reach:
    """As far both ways."""
    return lambda machine, guess: (guess - reach(machine), guess + reach(machine), False)


class Sought(NamedTuple):
    """A value of a block: where it stands, its unit, how far it is searched, and what of a log tells it."""

    key: str
    unit: str
    reach: Reach
    excitation: str


FILLING = "steps large enough to open the valve fully, both ways"
SLOW = "slow ramps over the stroke, both ways"
CENTRE = "small motions about the valve's centre"
PAUSES = "pauses of seconds"


def _span(machine: Machine) -> float:
    return machine.valve.volts_to_full if machine.valve is not None else 1.0


def _longest_delay(machine: Machine, _: float) -> float:
    return LONGEST * machine.cycle


def _sensor_span(machine: Machine) -> float:
    return machine.pressure_sensor.range if machine.pressure_sensor is not None else 0.0


VALVE = (
    Sought("conductance", "m^3/(s Pa)", times(3.0), FILLING),
    Sought("critical_ratio", "1", between(0.05, 0.9), "filling from low pressure and venting to it"),
    Sought("leakage", "m^3/(s Pa)", times(20.0, 1e-9), PAUSES),
    Sought("centre_voltage", "V", around(lambda machine: 0.2 * _span(machine)), PAUSES),
    Sought("volts_to_full", "V", times(2.0), "voltages beyond full opening"),
    Sought("delay", "s", up_to(_longest_delay), "steps, and chirps up to 3 Hz"),
)
SPOOL = (
    Sought("overlap", "1", between(0.0, 0.3), CENTRE),
    Sought("natural_frequency", "Hz", times(4.0), "steps, with the pressure sampled every few milliseconds"),
)
SWITCHING = (
    Sought("dead_band", "1", between(0.0, 0.3), CENTRE),
    Sought("opening_delay", "s", times(3.0), "pulses of all lengths"),
    Sought("closing_delay", "s", times(3.0), "pulses of all lengths"),
)
HOSE = (
    Sought("hose.torque_factor", "1", times(2.0), "fast moves of a known payload"),
    Sought("hose.dead_volume", "m^3", times(3.0), FILLING),
    Sought("hose.compliance", "m^3/Pa", times(10.0, 1e-10), "filling from low pressure"),
    Sought("hose.wall_conductance", "W/K", times(10.0, 10.0), "fast filling, then pauses of seconds"),
)
LOSSES = (
    Sought("hose.loss_share", "1", times(3.0, 0.5, most=1.0), SLOW),
    Sought("losses.pressure_free", "1", between(0.0, 1.0), f"{SLOW}, at two supply pressures"),
    Sought("losses.deflections.0", "rad", times(5.0), "small motions to and fro"),
    Sought("losses.deflections.1", "rad", times(5.0), "motions of a few degrees to and fro"),
    Sought("losses.deflections.2", "rad", times(4.0), "slow ramps of several sizes"),
)
FRICTION = (
    Sought("brake.torque", "N m", times(5.0, 5.0), SLOW),
    Sought("brake.viscous", "N m s/rad", times(20.0, 1.0), "chirps up to 3 Hz"),
)
INERTIA = (Sought("link.inertia", "kg m^2", plainly(3.0, 0.1), "chirps up to 3 Hz without payload"),)
PAYLOAD = Sought("arm.payload", "kg", up_to(lambda _, guess: max(3.0 * guess, 2.0)), "chirps up to 3 Hz")
SENSORS = Sought(
    "pressure_sensor.offset", "Pa", around(lambda machine: 0.02 * _sensor_span(machine)), "both pressures by themselves"
)

BY_JOINT = {"hose": HOSE, "losses": LOSSES, "friction": FRICTION, "inertia": INERTIA}
BLOCKS = ("valve", *BY_JOINT, "payload", "sensors")
"""What `--fit` takes for a machine that moves."""


def unknowns(machine: Machine, blocks: Sequence[str]) -> list[Unknown]:
    """What is to be found of a machine.

    Raises:
        InputError: there is no such block, or none is given.
    """
    strange = [block for block in blocks if block not in BLOCKS]
    if strange or not blocks:
        what = f"{strange[0]!r} is no block" if strange else "names no block"
        raise InputError(what, where="fit", right=f"choose of {', '.join(BLOCKS)}")
    return [_unknown(machine, path, sought) for block in dict.fromkeys(blocks) for path, sought in _of(machine, block)]


def _of(machine: Machine, block: str) -> list[tuple[str, Sought]]:
    """Paths of a block, with what is sought there."""
    if block == "valve":
        own = SWITCHING if isinstance(machine.valve, SwitchingValves) else SPOOL
        return [(f"valve.{sought.key}", sought) for sought in VALVE + own]
    if block in BY_JOINT:
        return [(f"joint.{name}.{sought.key}", sought) for name in machine.joints for sought in BY_JOINT[block]]
    sought = PAYLOAD if block == "payload" else SENSORS
    return [(sought.key, sought)]


def _unknown(machine: Machine, path: str, sought: Sought) -> Unknown:
    guess = float(value_at(machine, path))
    low, high, log = sought.reach(machine, guess)
    return Unknown(path, sought.unit, guess, low, high, log, sought.excitation, floor=low == 0.0)
