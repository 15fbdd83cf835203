"""Values that vary from run to run of an ensemble, as people give them: numbers in SI units, or texts with units."""

from contextlib import suppress
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.change import annotation_at, quantity_of
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.machine.signal_ranges import check_signal
from layflat.motion.signal_values import read_number

MAX_SEED = 2**53  # up to here floating-point numbers are all whole numbers

QUANTITIES: dict[str, u.Quantity | None] = {
    "scenario.payload": u.MASS,
    "scenario.supply": u.PRESSURE,
    "scenario.load": u.TORQUE,
    "scenario.drift": u.VOLTAGE,
    "scenario.lead": u.ERROR_GAIN,
    "scenario.pressure_lead": u.PRESSURE_GAIN,
    "scenario.spring": u.STIFFNESS,
    "scenario.damper": u.DAMPING,
    "start.angle": u.ANGLE,
    "start.pressure_a": u.PRESSURE,
    "start.pressure_b": u.PRESSURE,
}
"""Kinds of values that are no numbers of a machine; others are numbers without unit."""

CHECKED = {f"scenario.{name}": name for name in ("payload", "supply", "load", "drift")} | {
    "start.pressure_a": "pressures", "start.pressure_b": "pressures",
}  # fmt: skip
"""Signals whose plausible values hold for these."""


def read_values(machine: Machine, key: str, values: Any) -> Array:
    """Return the values of what varies, one a run, in SI units.

    Args:
        machine: the machine whose numbers vary.
        key: of `vary`.
        values: numbers in SI units or texts with units, one a run.

    Raises:
        InputError: they are not one real, finite number a run.
    """
    where, right = f"vary: {key}", "give one number a run"
    if isinstance(values, (str, bytes)) or not hasattr(values, "__len__") or isinstance(values, (dict, set)):
        raise InputError(f"{shown(values)} is no list", where=where, right=right)
    if isinstance(values, np.ma.MaskedArray):
        raise InputError("holds masked values", where=where, right="give an array without a mask")
    try:
        array = np.asarray(values)
    except ValueError:  # lists of several lengths
        raise InputError("is a list of lists", where=where, right=right) from None
    if array.ndim != 1 or len(array) == 0:
        raise InputError(f"has shape {array.shape}", where=where, right=right)
    if array.dtype.kind not in "iuf":
        items = values if isinstance(values, (list, tuple)) else array.tolist()
        array = np.array([read_number(value, _quantity(machine, key), where) for value in items])
    if not np.isfinite(array).all():
        raise InputError("holds a value that is not finite", where=where, right="give numbers only")
    if key == "seed" and not ((array >= 0) & (array <= MAX_SEED) & (array == np.floor(array))).all():
        raise InputError("holds what is no seed", where=where, right=f"give whole numbers, 0 to {MAX_SEED}")
    return array.astype(np.float64)


def check_values(machine: Machine, key: str, values: Array) -> None:
    """Raise InputError if values (SI) that are no numbers of a machine are not plausible for it."""
    where, joint = f"vary: {key}", key.rpartition(".")[2]
    signal = next((name for start, name in CHECKED.items() if key == start or key.startswith(f"{start}.")), None)
    if signal is not None:
        check_signal(machine, signal, values, where)
    if key.startswith("start.angle.") and joint in machine.joints:
        parameters.check_inside_stroke(machine, joint, float(values[np.argmax(np.abs(values))]), where)
    if (key == "scenario.brake" or key.startswith("scenario.brake.")) and (values < 0.0).any():
        raise InputError(f"{values.min():g} is out of range", where=where, right="give factors of zero or more")


def _quantity(machine: Machine, key: str) -> u.Quantity | None:
    """Return the kind of what varies; None of numbers without unit, and of what there is not."""
    for start, quantity in QUANTITIES.items():
        if key == start or key.startswith(f"{start}."):
            return quantity
    with suppress(InputError, KeyError, AttributeError, IndexError, ValueError):
        return quantity_of(annotation_at(machine, key))
    return None
