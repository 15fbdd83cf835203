"""Values that vary from run to run of an ensemble, as users write them: numbers in SI units, or texts with units."""

from contextlib import suppress
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.change import annotation_at, quantity_of
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.motion.scenario import HOSE_PRESSURE, SIGNALS, SignalRow
from layflat.motion.signal_values import read_number

MAX_SEED = 2**53  # up to here floating-point numbers are all whole numbers

EXTRA_QUANTITIES: dict[str, u.Quantity | None] = {
    "scenario.lead": u.ERROR_GAIN,
    "scenario.pressure_lead": u.PRESSURE_GAIN,
    "scenario.spring": u.STIFFNESS,
    "scenario.damper": u.DAMPING,
    "start.angle": u.ANGLE,
    "start.pressure_a": u.PRESSURE,
    "start.pressure_b": u.PRESSURE,
}
"""Quantities of the keys of `vary` that are neither signals nor numbers of a machine."""


def read_values(machine: Machine, key: str, values: Any) -> Array:
    """Return the values of a key of `vary` in SI units, (runs,).

    Args:
        machine: the machine whose numbers vary.
        key: key of `vary`.
        values: numbers in SI units or texts with units, one per run.

    Raises:
        InputError: they are not one real, finite number per run.
    """
    where, right = f"vary: {key}", "give one number a run"
    if isinstance(values, (str, bytes)) or not hasattr(values, "__len__") or isinstance(values, (dict, set)):
        raise InputError(f"{shown(values)} is no list", where=where, right=right)
    if isinstance(values, np.ma.MaskedArray):
        raise InputError("holds masked values", where=where, right="give a number for each of them")
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
        raise InputError("holds a number that is no seed", where=where, right=f"give whole numbers, 0 to {MAX_SEED}")
    return array.astype(np.float64)


def check_values(machine: Machine, key: str, values: Array) -> None:
    """Check that values of signals and starts, which are no numbers of the machine, are plausible for it.

    Args:
        machine: the machine that they act on.
        key: key of `vary`.
        values: one per run, SI.

    Raises:
        InputError: a value is out of range.
    """
    where, joint = f"vary: {key}", key.rpartition(".")[2]
    row = _signal(key)
    if row is not None and row.varies != "factor":
        row.check(machine, values, where)
    elif row is not None and (values < 0.0).any():
        raise InputError(f"{values.min():g} is out of range", where=where, right="give factors of zero or more")
    if key.startswith("start.pressure_"):
        HOSE_PRESSURE.check(values, where)
    if key.startswith("start.angle.") and joint in machine.joints:
        parameters.check_inside_stroke(machine, joint, float(values[np.argmax(np.abs(values))]), where)


def _signal(key: str) -> SignalRow | None:
    """Return the signal that a key of `vary` names, for all joints or for one; None if it names no signal."""
    start, _, rest = key.partition(".")
    return SIGNALS.get(rest.partition(".")[0]) if start == "scenario" else None


def _quantity(machine: Machine, key: str) -> u.Quantity | None:
    """Return the quantity of a key of `vary`; None for numbers without unit and unknown keys."""
    if (row := _signal(key)) is not None:
        return row.quantity
    for start, quantity in EXTRA_QUANTITIES.items():
        if key == start or key.startswith(f"{start}."):
            return quantity
    with suppress(InputError, KeyError, AttributeError, IndexError, ValueError):
        return quantity_of(annotation_at(machine, key))
    return None
