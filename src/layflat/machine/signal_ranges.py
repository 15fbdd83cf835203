"""Plausible values of signals that act on a machine: one outside is a mistake in a unit, a sign or a meaning."""

from math import inf
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine.model import Machine

MAX_SPEED = 200.0  # of a demand, rad/s: ten times as fast as the lightest arm
MAX_ACCELERATION = 1e5  # of a demand, rad/s2
MAX_STIFFNESS = 1e5  # of a joint, N m/rad
MAX_LOAD = 2e3  # torque on a joint from outside, N m: hoses of 300 mm give 500 N m
MAX_PAYLOAD = 500.0  # kg
MAX_PRESSURE = 100e5  # gauge or absolute: no layflat hose bears more, Pa
MIN_PRESSURE = 1e3  # absolute, of a hose, Pa: less is nearly a vacuum, or was meant in bar
MIN_SUPPLY = 1e3  # gauge, Pa: a supply that never has so much was meant in another unit, unless it is zero
VOLTAGE_ROUNDING = 0.05  # part of the span by which a logged voltage may lie outside


class SignalRange(NamedTuple):
    """Values that a signal may have."""

    lower: float  # SI
    upper: float
    unit: str  # "" of a share
    right: str  # such values in words
    lower_included: bool = True


def signal_range(machine: Machine, name: str) -> SignalRange:
    """Return the plausible values of a signal of a machine, by the name of its field in a scenario."""
    if name in {"voltage", "drift"}:
        return _voltage_range(machine, name)
    if name == "supply":
        right = f'a gauge pressure above vacuum, up to {MAX_PRESSURE / 1e5:g} bar, such as "4 bar"'
        return SignalRange(-machine.supply.ambient_pressure, MAX_PRESSURE, "Pa", right, lower_included=False)
    return _RANGES[name]


_RANGES = {
    "demand_velocity": SignalRange(
        -MAX_SPEED, MAX_SPEED, "rad/s", f'at most {MAX_SPEED:g} rad/s, such as "60 deg/s"; numbers are in rad/s'
    ),
    "demand_acceleration": SignalRange(
        -MAX_ACCELERATION, MAX_ACCELERATION, "rad/s2",
        f'at most {MAX_ACCELERATION:g} rad/s2, such as "30 rad/s^2"; numbers are in rad/s2',
    ),
    "demand_stiffness": SignalRange(
        0.0, MAX_STIFFNESS, "N m/rad", f'a stiffness of zero or more, up to {MAX_STIFFNESS:g}, such as "20 N m/rad"'
    ),
    "opening": SignalRange(-1.0, 1.0, "", "a share from -1 to 1"),
    "brake": SignalRange(0.0, 1.0, "", "a share from 0 to 1"),
    "dither": SignalRange(0.0, 1.0, "", "a share from 0 to 1"),
    "load": SignalRange(-MAX_LOAD, MAX_LOAD, "N m", f'at most {MAX_LOAD:g} N m, such as "2 N m"'),
    "payload": SignalRange(
        0.0, MAX_PAYLOAD, "kg", f'a mass of zero or more, up to {MAX_PAYLOAD:g} kg, such as "1.5 kg"'
    ),
    "pressures": SignalRange(
        MIN_PRESSURE, 2.0 * MAX_PRESSURE, "Pa", 'absolute pressures such as "3.5 bar"; numbers are in Pa'
    ),
}  # fmt: skip


def _voltage_range(machine: Machine, name: str) -> SignalRange:
    valve = machine.valve
    if valve is None:
        return SignalRange(-inf, inf, "V", "a voltage")
    span = valve.volts_to_full
    if name == "drift":
        right = f'a shift of up to {span:g} V, which opens the valve fully, such as "0.2 V"'
        return SignalRange(-span, span, "V", right)
    centre, spare = valve.centre_voltage, VOLTAGE_ROUNDING * span
    right = f"{centre - span:g} to {centre + span:g} V, the range of the valve"
    return SignalRange(centre - span - spare, centre + span + spare, "V", right)


def check_signal(machine: Machine, name: str, values: Any, where: str = "") -> Array:
    """Return values of a signal (SI, any shape; not a number: as usual) if all are plausible for the machine.

    Args:
        machine: the machine that they act on.
        name: field of a scenario, such as "brake".
        values: of the signal, in SI units.
        where: the argument in messages; default: the name.

    Raises:
        InputError: naming `where`: a value is out of range.
    """
    array, limits, where = np.asarray(values, dtype=float), signal_range(machine, name), where or name
    low = array >= limits.lower if limits.lower_included else array > limits.lower
    good = np.isnan(array) | (low & (array <= limits.upper))
    if not good.all():
        unit = f" {limits.unit}" if limits.unit else ""
        raise InputError(f"{array[~good][0]:g}{unit} is out of range", where=where, right=f"give {limits.right}")
    if name == "supply" and 0.0 < np.nanmax(np.abs(array), initial=0.0) < MIN_SUPPLY:
        what = f"{array[array != 0.0][0]:g} Pa is hardly any pressure"
        raise InputError(what, where=where, right='give a gauge pressure such as "4 bar"; numbers are in Pa')
    return array
