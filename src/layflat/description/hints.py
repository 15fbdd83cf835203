"""What was probably meant by a name that is not known."""

from collections.abc import Iterable
from difflib import get_close_matches

MOST_LISTED = 12


def nearest(name: object, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Return the known name that is most like another, None where none is."""
    names = list(known)
    same = [one for one in names if one.lower() == str(name).lower()]
    return next(iter(same or get_close_matches(str(name), names, n=1, cutoff=cutoff)), None)


def did_you_mean(name: object, known: Iterable[str], otherwise: str = "known are {}") -> str:
    """Return the question whether the nearest was meant; `otherwise`, with all that are known, where none is near."""
    names = list(known)
    near = nearest(name, names)
    if near is not None:
        return f"did you mean {near!r}?"
    return otherwise.format(", ".join(names[:MOST_LISTED]) + (", ..." if len(names) > MOST_LISTED else ""))
