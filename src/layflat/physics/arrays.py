"""Laws of numbers for parameters that may be arrays, an item a run."""

from collections.abc import Callable
from typing import Any

import numpy as np


def itemwise(law: Callable[..., float], *args: Any) -> float:
    """A law of numbers, or of arrays item by item."""
    if any(isinstance(arg, np.ndarray) for arg in args):
        return np.vectorize(law, otypes=[float])(*args)  # type: ignore[no-any-return]
    return float(law(*args))
