"""One fruit as a camera detected it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fruit:
    """One detected fruit, taken as a sphere that lies on the table.

    Args:
        x: of its centre, m, in the frame of the arm's base.
        y: as x.
        diameter: m.
        kind: such as "tomato".
        grade: such as "A"; empty where there is none.
        confidence: that there is one, of this kind, 0 to 1.
        doubt: why it has no grade, as a clause; empty where it has one.
    """

    x: float
    y: float
    diameter: float
    kind: str
    grade: str
    confidence: float = 1.0
    doubt: str = ""

    @property
    def radius(self) -> float:
        """Half its diameter, m."""
        return self.diameter / 2
