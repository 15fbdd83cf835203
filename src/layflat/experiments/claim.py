"""A claim of the paper beside what was simulated."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

Value = float | dict[str, float]


@dataclass(frozen=True)
class Claim:
    """One claim: where the paper makes it, what it says, what came out, and whether that agrees.

    Args:
        id: short name.
        where: section, table or figure of the paper.
        paper: what the paper says, in our words.
        simulated: one number, or several by name.
        unit: of the number or numbers.
        agrees: whether `criterion` holds.
        criterion: when the two agree.
    """

    id: str
    where: str
    paper: str
    simulated: Value
    unit: str
    agrees: bool
    criterion: str

    def record(self) -> dict[str, Any]:
        """As it stands in claims.json; a value that is not finite becomes null."""
        return {
            "id": self.id,
            "where": self.where,
            "paper": self.paper,
            "simulated": _json(self.simulated),
            "unit": self.unit,
            "agrees": bool(self.agrees),
            "criterion": self.criterion,
        }


def _json(value: Value) -> Any:
    if isinstance(value, dict):
        return {name: _json(number) for name, number in value.items()}
    number = float(value)
    return round(number, 6) if isfinite(number) else None
