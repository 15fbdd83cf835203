"""What people write behind options: angles of several joints, and values with a time."""

from __future__ import annotations

from collections.abc import Sequence

from layflat.description import units as u
from layflat.errors import InputError

Values = dict[str, str | float]
Steps = list[tuple[float, Values]]


def timed(texts: Sequence[str], first: Values, where: str, *, bare: bool = False) -> Steps:
    """Steps from texts such as "40 deg, 20 deg", "large=40 deg @ 2 s", beginning with the values in `first`.

    A name that a text does not mention keeps its value; a single value is meant for all names. `bare` values are
    numbers without unit.

    Raises:
        InputError: naming the option and what it should look like.
    """
    parsed = sorted((_one(text, list(first), where, bare) for text in texts), key=lambda item: item[0])
    steps: Steps = [(0.0, first)]
    for time, values in parsed:
        kept = {**steps[-1][1], **values}
        if steps[-1][0] == time:
            steps.pop()
        steps.append((time, kept))
    return steps


def _one(text: str, names: Sequence[str], where: str, bare: bool) -> tuple[float, Values]:
    body, at, when = text.partition("@")
    time = u.quantity(when.strip(), u.TIME, where) if at else 0.0
    if time < 0.0:
        raise InputError(f"{when.strip()!r} is before the start", where=where, right='give a time such as "@ 2 s"')
    items = [item.strip() for item in body.split(",")]
    if any("=" in item for item in items):
        return time, dict(_named(item, names, where, bare) for item in items)
    if len(items) == 1:
        return time, dict.fromkeys(names, _value(items[0], where, bare))
    if len(items) != len(names):
        raise InputError(
            f"{text!r} has {len(items)} values", where=where, right=f"give {len(names)}: {', '.join(names)}"
        )
    return time, {name: _value(item, where, bare) for name, item in zip(names, items, strict=True)}


def _named(item: str, names: Sequence[str], where: str, bare: bool) -> tuple[str, str | float]:
    name, _, value = (part.strip() for part in item.partition("="))
    if name not in names:
        raise InputError(f"unknown joint {name!r}", where=where, right=f"joints are {', '.join(names)}")
    return name, _value(value, where, bare)


def _value(text: str, where: str, bare: bool) -> str | float:
    if not bare:
        return text
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{text!r} is not a number", where=where, right="give a number such as 0.5") from None
