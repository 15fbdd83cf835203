"""Values as a description file can hold them: within the range of their quantity and the bounds of their key."""

from collections.abc import Iterator, Mapping
from itertools import product
from math import copysign, isfinite
from typing import Any, get_args

from annotated_types import Ge, Gt, Le, Lt

from layflat.description import Part
from layflat.description import units as u
from layflat.description.change import annotation_at, changed_all, quantity_of, value_at
from layflat.errors import InputError

DIGITS = (7, 17)  # of a number in a file: as people read it, or all of them where rounding breaks a rule
INWARD = (0.0, 1e-6, 1e-5)  # relative moves away from a bound, for texts that round beyond it
ROUNDED = 1e-6  # a text that differs by less, relative, is the same value, rounded


def file_texts(described: Part, values: Mapping[str, float], before: Mapping[str, Any]) -> dict[str, str | float]:
    """Return values as texts that a file of this description takes, each alone and all together.

    A magnitude that makes no sense for its quantity, as 6e-10 m of a length, is written as the nearest that does: zero
    where zero may stand.

    Args:
        described: the description that holds the values.
        values: by dotted path, SI.
        before: texts or numbers that stand there, by path: each new text has the unit of the one before.

    Returns:
        Texts with units, or numbers where the quantity has none, by path.

    Raises:
        InputError: the values can't stand together, such as a stop inside the reading.
    """
    refused: InputError | None = None
    for digits in DIGITS:
        texts = {path: file_text(described, path, value, before.get(path), digits) for path, value in values.items()}
        try:
            changed_all(described, texts)
        except InputError as error:
            refused = error
        else:
            return texts
    assert refused is not None
    raise refused


def holds_another(described: Part, path: str, text: str | float, value: float) -> bool:
    """Return whether a text at a path holds another value than this one (SI), beyond rounding.

    Args:
        described: the description.
        path: dotted.
        text: with its unit, or a plain number.
        value: SI.
    """
    try:
        held = float(value_at(changed_all(described, {path: text}, together=False), path))
    except InputError:  # holds none
        return False
    return abs(held - value) > ROUNDED * max(abs(value), abs(held))


def si_unit(described: Part, path: str) -> str:
    """Return the SI unit of what stands at a path; "1" of a plain number."""
    quantity = quantity_of(annotation_at(described, path))
    return quantity.unit if quantity else "1"


def file_text(described: Part, path: str, value: float, before: Any, digits: int = DIGITS[0]) -> str | float:
    """Return one value (SI) as a text that its key takes: see `file_texts`.

    Args:
        described: the description.
        path: dotted.
        value: SI.
        before: what stands there, or None.
        digits: of the number.

    Raises:
        InputError: the key takes nothing near it.
    """
    refused: InputError | None = None
    for candidate in _candidates(annotation_at(described, path), value):
        text = u.alike(before, candidate, si_unit(described, path), digits)
        try:
            changed_all(described, {path: text}, together=False)
        except InputError as error:
            refused = error
        else:
            return text
    assert refused is not None
    raise refused


def _candidates(annotation: Any, value: float) -> Iterator[float]:
    """The value, or the nearest ones that a key allows, the nearest first."""
    if not isfinite(value):
        yield value
        return
    notes = get_args(annotation)[1:]
    quantity = quantity_of(annotation)
    least, most = (quantity.least, quantity.most) if quantity else (0.0, float("inf"))
    value += 0.0  # no negative zero
    lowest = [float(getattr(one, "ge" if isinstance(one, Ge) else "gt")) for one in notes if isinstance(one, (Ge, Gt))]
    highest = [float(getattr(one, "le" if isinstance(one, Le) else "lt")) for one in notes if isinstance(one, (Le, Lt))]
    inside = min(max(value, *lowest, -most), *highest, most)
    if 0.0 < abs(inside) < least:
        yield 0.0
    # A bound that is not allowed itself, or a text that rounds beyond it: a little inward, up or down.
    small = max(least, 1e-12)
    for share, way in product(INWARD, (1.0, -1.0)):
        moved = inside + way * share * max(abs(inside), small)
        yield copysign(max(abs(moved), least), moved) if moved != 0.0 else 0.0
    yield from (small, -small)
