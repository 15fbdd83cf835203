"""Derivatives by central differences."""

from typing import Any

import numpy as np

from layflat.arrays import Array


def jacobian(function: Any, point: Array, changes: Any) -> Array:
    """Return the derivatives of a function of an array by its numbers, by central differences.

    Args:
        function: from an array (n,) to an array of any shape, which is flattened to (m,).
        point: where, (n,).
        changes: change of each number, (n,).

    Returns:
        Derivatives, (m, n).
    """
    columns = []
    for i, change in enumerate(changes):
        aside = np.zeros_like(point)
        aside[i] = change
        columns.append(np.ravel(function(point + aside) - function(point - aside)) / (2.0 * change))
    return np.array(columns).T if columns else np.zeros((len(np.ravel(function(point))), 0))
