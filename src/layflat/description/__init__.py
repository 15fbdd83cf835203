"""Descriptions that users write: text, tables and quantities with units, validated into frozen objects.

Files of machines, test benches, cells, studies and mappings are schemas on top of this room.
"""

from collections.abc import Collection, Iterator
from typing import Any

from pydantic import BaseModel, ConfigDict, PrivateAttr, model_validator

from layflat.description.names import Name
from layflat.description.tables import Provenance


class Part(BaseModel):
    """Base of all tables of a description: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)


def ordered(lower: str, upper: str, problem: str, *, may_equal: bool = False) -> Any:
    """Return a validator of a part, which raises ValueError unless one value is below another one.

    Args:
        lower: key of the smaller value.
        upper: key of the greater value.
        problem: text of the error: the problem and, after a semicolon, the advice.
        may_equal: accept equal values.
    """

    def check(part: Part) -> Part:
        low, high = getattr(part, lower), getattr(part, upper)
        if low > high or (low == high and not may_equal):
            raise ValueError(problem)
        return part

    return model_validator(mode="after")(check)


def _path_and_parents(path: str) -> Iterator[str]:
    """Yield a dotted path and those of the parts that it is in."""
    while path:
        yield path
        path = path.rpartition(".")[0]


class DescribedFile(Part):
    """Base of descriptions of a whole file, with the origin of the file and the source of each value."""

    name: Name
    title: str
    _provenance: dict[str, Provenance] = PrivateAttr(default_factory=dict)
    _origin: str = PrivateAttr(default="")

    @property
    def provenance(self) -> dict[str, Provenance]:
        """Source of each value by its dotted path; "given" if the file names none."""
        return self._provenance

    def note_given(self, paths: Collection[str]) -> None:
        """Set the source of the values at and below some dotted paths to "given", in place; of an item, of its list."""
        given = {path.rpartition(".")[0] if path.rpartition(".")[2].isdigit() else path for path in paths}
        kept = {key: source for key, source in self._provenance.items() if not given & set(_path_and_parents(key))}
        self._provenance = kept | dict.fromkeys(given, Provenance())

    @property
    def origin(self) -> str:
        """File or built-in name from which it was loaded, else its own name: for messages."""
        return self._origin or self.name


__all__ = ["DescribedFile", "Part", "ordered"]
