"""Bounded least squares of what lies outside a disc: a projected Newton method for few rows and many unknowns.

| symbol | meaning | unit |
|---|---|---|
| x | unknowns | 1 |
| v | points, linear in x: v = v_0 + A x | 1 |
| w | excess of a point: its distance from the origin less the radius, or zero | 1 |
| f | what is least: the sum of w^2, and lam x^2 | 1 |
"""

import numpy as np

from layflat.arrays import Array

ITERATIONS = 30
ENOUGH = 1e-4  # an iteration that gains a smaller share is the last
LENGTHS = 0.5 ** np.arange(11)  # of steps along the Newton direction, of which the best is taken


def least_excess(v_0: Array, A: Array, radius: float, lam: float, low: Array, high: Array) -> Array:
    """Return x, (unknowns,), within bounds, such that the sum of squared excesses and lam x^2 is least.

    Source: projected Newton method of Bertsekas 1982 (key bertsekas1982).

    Args:
        v_0: points where x = 0, (points, 2).
        A: their change with x, (points, 2, unknowns).
        radius: of the disc in which a point has no excess.
        lam: weight of x, > 0.
        low: bounds of x, (unknowns,), not above zero.
        high: likewise, not below zero.
    """
    x, v, before = np.zeros(A.shape[2]), v_0, np.inf
    flat = A.reshape(-1, A.shape[2])
    for _ in range(ITERATIONS):
        slope, rows = _expanded(v, A, radius)
        g = slope + lam * x
        free = ~(((x <= low) & (g > 0.0)) | ((x >= high) & (g < 0.0)))
        step = np.where(free, -_solved(rows * free, lam, g * free), 0.0)
        tried = np.clip(x + LENGTHS[:, None] * step, low, high)
        points = v_0 + (tried @ flat.T).reshape(-1, *v_0.shape)
        excess = np.maximum(np.sqrt((points * points).sum(axis=2)) - radius, 0.0)
        f = (excess * excess).sum(axis=1) + lam * (tried * tried).sum(axis=1)
        i = int(np.argmin(f))
        if before - f[i] < ENOUGH * before:
            break
        x, v, before = tried[i], points[i], f[i]
    return x


def _expanded(v: Array, A: Array, radius: float) -> tuple[Array, Array]:
    """Half the gradient of the squared excesses, and the rows B of half their second derivative B'B."""
    distance = np.maximum(np.linalg.norm(v, axis=1), 1e-12)
    out = distance > radius
    along, A, excess = v[out] / distance[out, None], A[out], distance[out] - radius
    radial = np.einsum("pi,pin->pn", along, A)
    tangential = np.einsum("pi,pin->pn", along[:, ::-1] * (-1.0, 1.0), A) * np.sqrt(excess / distance[out])[:, None]
    return excess @ radial, np.concatenate([radial, tangential])


def _solved(rows: Array, lam: float, g: Array) -> Array:
    """(B'B + lam)^-1 g by way of the rows, which are fewer than the unknowns."""
    small = rows @ rows.T + lam * np.eye(len(rows))
    return (g - rows.T @ np.linalg.solve(small, rows @ g)) / lam
