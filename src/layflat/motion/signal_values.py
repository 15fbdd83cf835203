"""Single values and rows of a signal as people write them: text with a unit, or numbers in SI units."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from math import inf, isfinite
from numbers import Real
from typing import Any, NamedTuple, SupportsFloat, TypeGuard, TypeVar

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.wrong import did_you_mean, shown
from layflat.errors import InputError

Value = str | float
Pair = tuple[Value, Value]  # of the hoses A and B
Angles = Value | Mapping[str, Value] | Sequence[Value]
"""Values of all joints: a single value, a table by joint, or one value per joint from base to tip."""

K = TypeVar("K")

NOUN_PLURALS = {"joint": "joints", "axis": "axes"}


class SignalKind(NamedTuple):
    """Kind of a signal: the quantity of its values, and the names of their columns."""

    where: str  # the argument in messages
    quantity: u.Quantity | None  # None: numbers without unit
    names: Sequence[str]  # of the joints, or of the axes of the tip
    noun: str = "joint"  # for one of the names; "" for a single value that all joints share

    @property
    def right(self) -> str:
        """Values that would be right, in words."""
        if self.quantity is None:
            return "give a number such as 0.5"
        return f"{self.quantity.right}, or a number in {self.quantity.unit}"

    @property
    def listed(self) -> str:
        """Names in words."""
        return f"give one value: {self.where} is the same for all joints" if not self.noun else (
            f"{NOUN_PLURALS[self.noun]} are {', '.join(self.names)}"
        )  # fmt: skip


class Sampling(NamedTuple):
    """Sampling instants of a signal: the beginnings of control cycles."""

    cycle: float  # s
    cycles: int

    @property
    def times(self) -> Array:
        """The instants, s, (cycles,)."""
        return self.cycle * np.arange(self.cycles, dtype=float)

    @property
    def end(self) -> float:
        """End of the last cycle, s."""
        return self.cycle * self.cycles


def single_kind(where: str, quantity: u.Quantity | None) -> SignalKind:
    """Return the kind of a signal that all joints share."""
    return SignalKind(where, quantity, (where,), "")


def is_real(value: object) -> TypeGuard[SupportsFloat]:
    """Return whether something is a real number; truth values and times of NumPy, which are its integers, are none."""
    return isinstance(value, Real) and not isinstance(value, (bool, np.bool_, np.timedelta64))


def read_number(value: object, quantity: u.Quantity | None, where: str) -> float:
    """Return the SI float of a text with a unit, or of a finite real number, which is in SI units.

    Args:
        value: a text such as "40 deg", or a number.
        quantity: the kind that it is of; None: a number without unit.
        where: the argument in messages.

    Raises:
        InputError: naming `where`: it is neither, not finite, or a quantity of another kind.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, str) and quantity is not None:
        return u.quantity(str(value), quantity, where)
    if not is_real(value):
        article = "a number" if quantity is None else quantity.article
        raise InputError(f"{shown(value)} is not {article}", where=where, right=single_kind(where, quantity).right)
    try:
        number = float(value)
    except OverflowError:
        number = inf
    if not isfinite(number):
        raise InputError(f"{shown(value)} is not finite", where=where, right=single_kind(where, quantity).right)
    return number


def read_row(values: object, kind: SignalKind, before: Array) -> Array:
    """Return one value a name, in SI units, (names,).

    Args:
        values: one for all names, one for each in order, or a table by name.
        kind: kind of the signal.
        before: values (names,) of names that a table leaves out: they keep what they had.

    Raises:
        InputError: a name is unknown, the number of values or one of them is wrong.
    """
    names, where = kind.names, kind.where
    if isinstance(values, Mapping):
        check_names(values, kind)
        pairs = zip(names, before, strict=True)
        return np.array([read_number(values[n], kind.quantity, where) if n in values else b for n, b in pairs])
    if isinstance(values, np.ndarray) and values.ndim > 0:
        check_real(values, kind)
        each: Sequence[Any] = list(values)
    elif isinstance(values, Sequence) and not isinstance(values, (str, bytes, bytearray, memoryview)):
        each = values
    elif kind.noun == "axis":
        raise InputError(f"{shown(values)} is not a position", where=where, right=f"give {', '.join(names)}")
    else:
        return np.full(len(names), read_number(values, kind.quantity, where))
    if any(isinstance(value, (list, tuple, Mapping)) for value in each):
        right = 'steps are tuples, [("0 s", ...), ("1 s", ...)]; rows for the control cycles are an array'
        raise InputError("is neither a row of values nor steps", where=where, right=right)
    if len(each) != len(names):
        right = f"give {len(names)}: {', '.join(names)}" if kind.noun else kind.listed
        raise InputError(f"has {len(each)} values", where=where, right=right)
    return np.array([read_number(value, kind.quantity, where) for value in each])


def check_names(names: Iterable[object], kind: SignalKind) -> None:
    """Raise InputError for a name that is none of the signal's."""
    for name in names:
        if not (isinstance(name, str) and name in kind.names):
            near = did_you_mean(name, kind.names, "")
            right = f"{kind.listed}; {near}" if kind.noun and near else kind.listed
            raise InputError(f"unknown {kind.noun or 'name'} {shown(name)}", where=kind.where, right=right)


def check_real(array: Any, kind: SignalKind) -> None:
    """Raise InputError if an array holds masked values, or others than real numbers or texts."""
    if isinstance(array, np.ma.MaskedArray) and np.ma.is_masked(array):
        raise InputError("holds masked values", where=kind.where, right="give a number for each of them")
    if array.dtype.kind not in "iufUO":
        raise InputError(f"an array of {array.dtype} holds no numbers", where=kind.where, right="give real numbers")


def read_duration(value: object) -> float:
    """Return a duration, s; raise InputError if it is none."""
    return read_number(value, u.TIME, "duration")


def check_bool(value: object, where: str) -> None:
    """Raise InputError, naming the argument `where`, for a value that is neither True nor False."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{shown(value)} is neither True nor False", where=where, right="give one of them")


def check_integer(value: object, where: str, lower: int, upper: int | None = None) -> int:
    """Return a whole number within bounds.

    Args:
        value: value to check.
        where: the argument in messages.
        lower: smallest allowed number.
        upper: largest allowed number; default: none.

    Raises:
        InputError: naming `where`: it is no whole number, or out of bounds.
    """
    right = f"give a whole number, {lower} or more" if upper is None else f"give {lower} to {upper}"
    if not (is_real(value) and isinstance(value, (int, np.integer))):
        raise InputError(f"{shown(value)} is not a whole number", where=where, right=right)
    if value < lower or (upper is not None and value > upper):
        raise InputError(f"{shown(value)} is out of range", where=where, right=right)
    return int(value)


def build_options(kind: type[K], options: Mapping[str, Any], where: str, base: K | None = None) -> K:
    """Return a dataclass of options, with defaults for those that are not given.

    Args:
        kind: the dataclass.
        options: values by name.
        where: the argument in messages.
        base: instance that supplies the defaults; default: those of the dataclass.

    Raises:
        InputError: an option is unknown.
    """
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    unknown = sorted(set(options) - set(names))
    if unknown:
        raise InputError(f"unknown option {unknown[0]!r}", where=where, right=did_you_mean(unknown[0], names, "use {}"))
    return replace(base or kind(), **options)  # type: ignore[type-var]
