"""Plausible values of signals that act on a machine: one outside is a mistake in a unit, a sign or a meaning."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.machine import Machine

MAX_PRESSURE = 100e5  # gauge or absolute: no layflat hose bears more, Pa
MIN_PRESSURE = 1e3  # absolute, of a hose, Pa: less is nearly a vacuum, or was meant in bar
MIN_SUPPLY = 1e3  # gauge, Pa: a supply that never has so much was meant in another unit, unless it is zero
VOLTAGE_ROUNDING = 0.05  # part of the span by which a logged voltage may lie outside


class Range(NamedTuple):
    """Values that a signal may have, in SI units."""

    lower: float
    upper: float
    unit: str  # "" of a share
    right: str  # such values in words
    lower_included: bool = True
    least: float = 0.0  # magnitude below which all of a signal is hardly anything, unless it is zero

    def check(self, values: Any, where: str) -> Array:
        """Return values (any shape; not a number: as usual) if all are in range; raise InputError naming `where`."""
        import numpy as np  # noqa: PLC0415  # the table of signals is read for help alone, too

        array = np.asarray(values, dtype=float)
        low = array >= self.lower if self.lower_included else array > self.lower
        good = np.isnan(array) | (low & (array <= self.upper))
        if not good.all():
            unit = f" {self.unit}" if self.unit else ""
            raise InputError(f"{array[~good][0]:g}{unit} is out of range", where=where, right=f"give {self.right}")
        if 0.0 < np.nanmax(np.abs(array), initial=0.0) < self.least:
            what = f"{array[array != 0.0][0]:g} {self.unit} is hardly any pressure"
            raise InputError(what, where=where, right='give a gauge pressure such as "4 bar"; numbers are in Pa')
        return array


def at_most(most: float, unit: str, right: str) -> Range:
    """Return the range of a signal of either sign."""
    return Range(-most, most, unit, right)


SHARE = Range(0.0, 1.0, "", "a share from 0 to 1")
HOSE_PRESSURE = Range(
    MIN_PRESSURE, 2.0 * MAX_PRESSURE, "Pa", 'absolute pressures such as "3.5 bar"; numbers are in Pa'
)  # fmt: skip


def supply_range(machine: Machine) -> Range:
    """Return the gauge pressures that a supply may have."""
    right = f'a gauge pressure above vacuum, up to {MAX_PRESSURE / 1e5:g} bar, such as "4 bar"'
    return Range(-machine.supply.ambient_pressure, MAX_PRESSURE, "Pa", right, lower_included=False, least=MIN_SUPPLY)


def drift_range(machine: Machine) -> Range:
    """Return the shifts that the centre of a valve may have."""
    if machine.valve is None:
        return Range(-inf, inf, "V", "a voltage")
    span = machine.valve.volts_to_full
    return at_most(span, "V", f'a shift of up to {span:g} V, which opens the valve fully, such as "0.2 V"')


def voltage_range(machine: Machine) -> Range:
    """Return the control voltages that a valve may have."""
    if machine.valve is None:
        return Range(-inf, inf, "V", "a voltage")
    span, centre = machine.valve.volts_to_full, machine.valve.centre_voltage
    spare = VOLTAGE_ROUNDING * span
    right = f"{centre - span:g} to {centre + span:g} V, the range of the valve"
    return Range(centre - span - spare, centre + span + spare, "V", right)


def centre_voltage(machine: Machine) -> float:
    """Return the voltage at which a valve is closed."""
    return 0.0 if machine.valve is None else machine.valve.centre_voltage
