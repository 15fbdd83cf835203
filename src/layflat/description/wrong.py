"""What our own checks say of a value: the problem, and what would be right."""

from pydantic_core import PydanticCustomError

WRONG = "layflat"  # type of such an error among pydantic's


INPUT = object()  # in place of a value: what stands in the file


def wrong(what: str, right: str = "", value: object = None) -> PydanticCustomError:
    """Return the error that a validator raises; `value`, or what stands in the file, is put before `what`."""
    text = what if value is None or value is INPUT else f"{shown(value)} {what}"
    return PydanticCustomError(WRONG, "{what}", {"what": text, "right": right, "named": value is not INPUT})


def shown(value: object, longest: int = 60) -> str:
    """Return a value as it can stand in a line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= longest else f"{text[: longest - 4]} ..."
