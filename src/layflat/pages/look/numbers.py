"""Numbers that come from a page: whatever a browser sends is a finite number, or none."""

from math import isfinite
from typing import Any


def number(value: Any) -> float | None:
    """Return what a field holds as a number; None where it holds none, or one that is not finite."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if abs(value) < 1e300 and isfinite(value) else None


def within(value: Any, lower: float, upper: float, otherwise: float) -> float:
    """Return the number that a slider holds, inside its limits; `otherwise` where it holds none."""
    found = number(value)
    return otherwise if found is None else min(max(found, lower), upper)
