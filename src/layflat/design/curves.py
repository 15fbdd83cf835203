"""Integral and derivatives of a curve through points, in two ways."""

from collections.abc import Callable

import numpy as np

from layflat.arrays import Array

Through = Callable[[Array, Array], tuple[Array, Array, Array]]
"""Yields the integral of y over rising x from the first point on, and y' and y'', at each point: shape (n,) each."""

ORDER = 5  # of the spline, which goes through more points than that


def spline(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Lay a quintic spline through all points."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415  # SciPy takes a second to import

    curve = make_interp_spline(x, y, k=ORDER)
    return curve.antiderivative()(x), curve.derivative(1)(x), curve.derivative(2)(x)


def stencils(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Lay a polynomial through each point and its neighbours: the spline's values to 1e-6, without SciPy."""
    powers = np.arange(min(ORDER + 2, len(x)))
    near = np.clip(np.arange(len(x)) - ORDER // 2, 0, len(x) - len(powers))[:, None] + powers
    away = x[near] - x[:, None]
    scale = np.ptp(away, axis=1, keepdims=True)
    terms = np.linalg.solve((away / scale)[..., None] ** powers, y[near][..., None])[..., 0] / scale**powers
    steps = (terms[:-1] * np.diff(x)[:, None] ** (powers + 1) / (powers + 1)).sum(axis=1)
    return np.concatenate(([0.0], np.cumsum(steps))), terms[:, 1], 2 * terms[:, 2]
