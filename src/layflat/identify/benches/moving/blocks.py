"""What can be fitted of a machine from motion and pressures, block by block, and how far around the description."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.identify.benches.contract import check_known
from layflat.identify.unknown import Unknown
from layflat.machine import Machine
from layflat.physics.delay import LONGEST
from layflat.physics.valves.switching import SwitchingValvesPart

Range = Callable[[Machine, float], tuple[float, float, bool]]
"""Bounds (SI) from the machine and its present value, and whether the search is logarithmic."""


def factor_range(factor: float, usual: float = 1.0, most: float = float("inf")) -> Range:
    """A factor both ways, logarithmic; where the machine says zero, from there to `usual`."""

    def span(_: Machine, guess: float) -> tuple[float, float, bool]:
        return (guess / factor, min(guess * factor, most), True) if guess > 0.0 else (0.0, usual, False)

    return span


def linear_range(factor: float, usual: float) -> Range:
    """As `factor_range`, but linear: what adds to something known does not change by factors."""

    def span(_: Machine, guess: float) -> tuple[float, float, bool]:
        return (guess / factor, guess * factor, False) if guess > 0.0 else (0.0, usual, False)

    return span


def fixed_range(low: float, high: float) -> Range:
    """These bounds, or the machine's own value where that lies beyond."""
    return lambda _, guess: (min(low, guess), max(high, guess), False)


def from_zero(most: Callable[[Machine, float], float]) -> Range:
    """From zero on."""
    return lambda machine, guess: (0.0, max(most(machine, guess), guess), False)


def around(span: Callable[[Machine], float]) -> Range:
    """As far both ways."""
    return lambda machine, guess: (guess - span(machine), guess + span(machine), False)


class ParameterSpec(NamedTuple):
    """A parameter of a block: where it stands, its unit, its range, and what a log must contain to identify it."""

    key: str
    unit: str
    span: Range
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
    ParameterSpec("conductance", "m^3/(s Pa)", factor_range(3.0), FILLING),
    ParameterSpec("critical_ratio", "1", fixed_range(0.05, 0.9), "filling from low pressure and venting to it"),
    ParameterSpec("leakage", "m^3/(s Pa)", factor_range(20.0, 1e-9), PAUSES),
    ParameterSpec("centre_voltage", "V", around(lambda machine: 0.2 * _span(machine)), PAUSES),
    ParameterSpec("volts_to_full", "V", factor_range(2.0), "voltages beyond full opening"),
    ParameterSpec("delay", "s", from_zero(_longest_delay), "steps, and chirps up to 3 Hz"),
)
SPOOL = (
    ParameterSpec("overlap", "1", fixed_range(0.0, 0.3), CENTRE),
    ParameterSpec(
        "natural_frequency", "Hz", factor_range(4.0), "steps, with the pressure sampled every few milliseconds"
    ),
)
SWITCHING = (
    ParameterSpec("dead_band", "1", fixed_range(0.0, 0.3), CENTRE),
    ParameterSpec("opening_delay", "s", factor_range(3.0), "pulses of all lengths"),
    ParameterSpec("closing_delay", "s", factor_range(3.0), "pulses of all lengths"),
)
HOSE = (
    ParameterSpec("hose.torque_factor", "1", factor_range(2.0), "fast moves of a known payload"),
    ParameterSpec("hose.dead_volume", "m^3", factor_range(3.0), FILLING),
    ParameterSpec("hose.compliance", "m^3/Pa", factor_range(10.0, 1e-10), "filling from low pressure"),
    ParameterSpec("hose.wall_conductance", "W/K", factor_range(10.0, 10.0), "fast filling, then pauses of seconds"),
)
LOSSES = (
    ParameterSpec("hose.loss_share", "1", factor_range(3.0, 0.5, most=1.0), SLOW),
    ParameterSpec("losses.pressure_free", "1", fixed_range(0.0, 1.0), f"{SLOW}, at two supply pressures"),
    ParameterSpec("losses.deflections.0", "rad", factor_range(5.0), "small motions to and fro"),
    ParameterSpec("losses.deflections.1", "rad", factor_range(5.0), "motions of a few degrees to and fro"),
    ParameterSpec("losses.deflections.2", "rad", factor_range(4.0), "slow ramps of several sizes"),
)
FRICTION = (
    ParameterSpec("brake.torque", "N m", factor_range(5.0, 5.0), SLOW),
    ParameterSpec("brake.viscous", "N m s/rad", factor_range(20.0, 1.0), "chirps up to 3 Hz"),
)
INERTIA = (ParameterSpec("link.inertia", "kg m^2", linear_range(3.0, 0.1), "chirps up to 3 Hz without payload"),)
PAYLOAD = ParameterSpec("arm.payload", "kg", from_zero(lambda _, guess: max(3.0 * guess, 2.0)), "chirps up to 3 Hz")
SENSORS = ParameterSpec(
    "pressure_sensor.offset", "Pa", around(lambda machine: 0.02 * _sensor_span(machine)), "both pressures by themselves"
)

BY_JOINT = {"hose": HOSE, "losses": LOSSES, "friction": FRICTION, "inertia": INERTIA}
BLOCKS = ("valve", *BY_JOINT, "payload", "sensors")
"""What `--fit` takes for a machine that moves."""


def unknowns(machine: Machine, blocks: Sequence[str]) -> list[Unknown]:
    """What is to be fitted of a machine.

    Raises:
        InputError: there is no such block, or none is given.
    """
    if not blocks:
        raise InputError("names no block", where="fit", right=f"choose from {', '.join(BLOCKS)}")
    chosen = check_known(blocks, BLOCKS, "fit", "block")
    return [_unknown(machine, path, spec) for block in chosen for path, spec in _of(machine, block)]


def _of(machine: Machine, block: str) -> list[tuple[str, ParameterSpec]]:
    """Paths of a block, with what is fitted there."""
    if block == "valve":
        own = SWITCHING if isinstance(machine.valve, SwitchingValvesPart) else SPOOL
        return [(f"valve.{spec.key}", spec) for spec in VALVE + own]
    if block in BY_JOINT:
        return [(f"joint.{name}.{spec.key}", spec) for name in machine.joints for spec in BY_JOINT[block]]
    spec = PAYLOAD if block == "payload" else SENSORS
    return [(spec.key, spec)]


def _unknown(machine: Machine, path: str, spec: ParameterSpec) -> Unknown:
    guess = float(value_at(machine, path))
    low, high, log = spec.span(machine, guess)
    return Unknown(path, spec.unit, guess, low, high, log, spec.excitation, floor=low == 0.0)
