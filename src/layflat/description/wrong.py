"""Words of messages about values: the problem, the advice, and the nearest valid name."""

from collections.abc import Iterable
from difflib import get_close_matches

from pydantic_core import PydanticCustomError

ERROR_TYPE = "layflat"  # type of the package's errors among pydantic's


INPUT_VALUE = object()  # in place of a value: the one in the file


def value_error(what: str, right: str = "", value: object = None) -> PydanticCustomError:
    """Return an error for a validator to raise.

    Args:
        what: the problem, as a clause that follows the value.
        right: advice.
        value: named before the problem; None for no value, `INPUT_VALUE` for the one in the file.
    """
    text = what if value is None or value is INPUT_VALUE else f"{shown(value)} {what}"
    return PydanticCustomError(ERROR_TYPE, "{what}", {"what": text, "right": right, "named": value is not INPUT_VALUE})


def shown(value: object, longest: int = 60) -> str:  # language: used in the messages of every room
    """Return the text of a value for a message of one line, cut to `longest` characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= longest else f"{text[: longest - 4]} ..."


MAX_SUGGESTED = 12


def nearest(name: object, choices: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Return the choice that is most similar to a name, None if none is.

    Args:
        name: name as the user wrote it.
        choices: valid names.
        cutoff: min similarity, 0..1; names that differ in case alone always match.
    """
    names = list(choices)
    same = [choice for choice in names if choice.lower() == str(name).lower()]
    return next(iter(same or get_close_matches(str(name), names, n=1, cutoff=cutoff)), None)


def did_you_mean(name: object, choices: Iterable[str], otherwise: str = "known are {}") -> str:
    """Return advice for an unknown name: the nearest choice, or all choices if none is similar.

    Args:
        name: name as the user wrote it.
        choices: valid names.
        otherwise: advice without a similar choice; its braces are replaced by the choices.
    """
    names = list(choices)
    near = nearest(name, names)
    if near is not None:
        return f"did you mean {near!r}?"
    return otherwise.format(", ".join(names[:MAX_SUGGESTED]) + (", ..." if len(names) > MAX_SUGGESTED else ""))
