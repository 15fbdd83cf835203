"""Bases of everything that is described."""

from typing import Any

from pydantic import BaseModel, ConfigDict, PrivateAttr, model_validator

from layflat.description.names import Name
from layflat.description.provenance import Provenance


class Part(BaseModel):
    """Base of all parts: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)


def ordered(lower: str, upper: str, problem: str, *, may_equal: bool = False) -> Any:
    """Return a validator of a part: it refuses, with a problem to tell, a value that is not below another one.

    Args:
        lower: key of the value that is to be the smaller one.
        upper: key of the other.
        problem: in one clause, with what would be right.
        may_equal: accept equal values.
    """

    def check(part: Part) -> Part:
        low, high = getattr(part, lower), getattr(part, upper)
        if low > high or (low == high and not may_equal):
            raise ValueError(problem)
        return part

    return model_validator(mode="after")(check)


class Described(Part):
    """Base of what a whole file describes: it knows where it and each of its values come from."""

    name: Name
    title: str
    _provenance: dict[str, Provenance] = PrivateAttr(default_factory=dict)
    _origin: str = PrivateAttr(default="")

    @property
    def provenance(self) -> dict[str, Provenance]:
        """Source of each value by its dotted path; "given" where the file does not say."""
        return self._provenance

    @property
    def origin(self) -> str:
        """The file or built-in name that it was loaded from, its own name where there is none: for messages."""
        return self._origin or self.name
