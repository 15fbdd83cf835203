"""One fruit as a camera detected it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fruit:
    """One detected fruit, taken as a sphere that lies on the table."""

    x: float  # of its centre, m, in the frame of the arm's base
    y: float
    diameter: float  # m
    kind: str  # such as "tomato"
    grade: str  # such as "A"; empty where there is none
    confidence: float = 1.0  # that there is one, of this kind, 0 to 1
    doubt: str = ""  # why it has no grade, as a clause

    @property
    def radius(self) -> float:
        """Half its diameter, m."""
        return self.diameter / 2
