"""Bodies that can be: mass spreads along each of three directions at right angles, never by less than nothing.

| symbol | meaning |
|---|---|
| I | inertia about the centre: moments and products xx, yy, zz, xy, xz, yz, (..., 6) |
| S | second moments of mass about the centre, (..., 3, 3): tr(I) / 2 - I |
"""

from collections.abc import Mapping

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Flags
from layflat.machine import Machine
from layflat.physics.arms.chain.description import six_moments

THICK, THIN = 1e-3, 1e-7  # least spread of mass along a direction over the greatest: usual, and of a thin body
SMALL = 1e-2  # share of the described spread that a body has at least along one direction
TURNS = 30  # in which a possible inertia is looked for that keeps what is sought


def spread_of(inertia: Array) -> Array:
    """S from I."""
    xx, yy, zz, xy, xz, yz = np.moveaxis(inertia, -1, 0)
    moments = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(*xx.shape, 3, 3)
    return np.asarray(0.5 * np.trace(moments, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - moments)


def inertia_of(spread: Array) -> Array:
    """I from S."""
    moments = np.trace(spread, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - spread
    return np.stack([moments[..., i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))], axis=-1)


def is_thin(inertia: Array) -> bool:
    """Whether a body spreads so little along a direction that those sought in its place may as well."""
    spread = np.linalg.eigvalsh(spread_of(inertia))
    return bool(spread[0] < THICK * spread[-1])


def possible(machine: Machine, columns: Mapping[str, Array]) -> dict[str, Array]:
    """Values of candidates by path, with inertias that bodies can have in place of those that none can.

    A body's mass spreads along three directions at right angles; where it would spread along one by less than nothing,
    it does by next to nothing instead. What acts on no joint gives way first, and is then among the values.
    """
    found = dict(columns)
    for name in machine.arm.joints if machine.arm.own_links else ():
        described = machine.arm.link[name].inertia
        paths = [f"arm.link.{name}.inertia.{i}" for i in range(len(described))]
        sought = np.array([path in columns for path in paths] + [False] * (6 - len(paths)))
        if sought.any():
            given = [columns.get(path, value) for path, value in zip(paths, described, strict=True)]
            asked = np.stack(np.broadcast_arrays(*six_moments(tuple(given))), axis=-1)
            nearest = _nearest(asked, sought, np.array(six_moments(described)))
            changed = np.any(nearest != asked, axis=0)
            found |= {path: nearest[:, i] for i, path in enumerate(paths) if sought[i] or changed[i]}
    return found


def _nearest(asked: Array, sought: Flags, described: Array) -> Array:
    """Inertias (candidates, 6) of bodies near those asked for, no thinner than the described one where that is thin.

    By turns the nearest body is taken, and what is sought of it put back as it was asked for.
    """
    usual = np.linalg.eigvalsh(spread_of(described))
    found, turns = asked, 1 if sought.all() else TURNS
    for turn in range(turns):
        values, vectors = np.linalg.eigh(spread_of(found))
        most = np.maximum(values[:, -1], SMALL * usual[-1])
        least = np.minimum(THICK * most, np.maximum(usual[0], THIN * most))
        poor = values[:, :1] < least[:, None]
        if not poor.any():
            break
        spread = (vectors * np.maximum(values, 2.0 * least[:, None])[:, None, :]) @ vectors.swapaxes(1, 2)
        nearest = inertia_of(spread)
        kept = asked if turn < turns - 1 else nearest
        found = np.where(poor, np.where(sought, kept, nearest), found)
    return found
