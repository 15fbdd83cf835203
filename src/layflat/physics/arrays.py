"""Laws of numbers for parameters that may be arrays, an item a run."""

from collections.abc import Callable
from typing import Any

from layflat.lazy import numpy as np

__all__ = ["itemwise"]


def itemwise(law: Callable[..., float], *args: Any) -> float:
    """Return the value of a law of numbers; if an argument is an array, the array of its values item by item."""
    if any(isinstance(arg, np.ndarray) for arg in args):
        return np.vectorize(law, otypes=[float])(*args)  # type: ignore[no-any-return]
    return float(law(*args))
