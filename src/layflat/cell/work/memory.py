"""What is known to lie where: pictures tell it, but the arm may hide some of it.

| symbol | meaning | unit |
|---|---|---|
| C | where the camera is | m |
| P | middle of a fruit | m |
| h | height of the arm's links | m |

The arm hides a fruit if the line of sight C P passes the links, or what hangs from the tip, by less than their radius
and what is seen of the fruit's own at that height: r (C_z - h) / (C_z - P_z).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray

from layflat.cell.plan.fruit import Fruit

Array = NDArray[np.float64]

SAME = 15e-3
"""Two sightings nearer than this are of one fruit, m: no two fit there."""

HANGING = 0.05
"""Radius of what hangs from the tip, m: lift, cup and the largest fruit."""


@dataclass(frozen=True)
class Shade:
    """What the arm hides from a camera while it is still.

    Args:
        camera: where it is, (3,) m.
        joints: axes of the joints and the tip, in order, (n + 1, 2) m.
        height: of the links' middle, m.
        radius: of the links with their drums, m.
        tall: half of the links' height, m.
    """

    camera: Array
    joints: Array
    height: float
    radius: float
    tall: float

    def hides(self, fruit: Fruit) -> bool:
        """Whether any of a fruit is hidden."""
        for height in np.linspace(self.height - self.tall, self.height + self.tall, 3).tolist():
            at, radius = self._seen_at(fruit, height)
            if min(_distance(at, a, b) for a, b in zip(self.joints[:-1], self.joints[1:], strict=True)) < (
                self.radius + radius
            ):
                return True
        for height in np.linspace(0.0, self.height, 5).tolist():
            at, radius = self._seen_at(fruit, max(height, fruit.radius))
            if float(np.linalg.norm(at - self.joints[-1])) < HANGING + radius:
                return True
        return False

    def _seen_at(self, fruit: Fruit, height: float) -> tuple[Array, float]:
        """Where the line of sight passes a height, and the fruit's radius as it seems there."""
        share = (self.camera[2] - height) / (self.camera[2] - fruit.radius)
        middle = np.array([fruit.x, fruit.y])
        at: Array = self.camera[:2] + share * (middle - self.camera[:2])
        return at, share * fruit.radius


def remembered(before: Sequence[Fruit], seen: Sequence[Fruit], shade: Shade | None) -> list[Fruit]:
    """What lies on the table by now: all that is in the open, and what was known of what the arm hides.

    Args:
        before: what was known.
        seen: in a new picture.
        shade: of the arm in that picture; None where it is out of sight.
    """
    if shade is None:
        return list(seen)
    in_the_open = [fruit for fruit in seen if not shade.hides(fruit)]
    hidden = [fruit for fruit in before if shade.hides(fruit) and not any(same(fruit, new) for new in in_the_open)]
    return in_the_open + hidden


def apart(one: Fruit, other: Fruit) -> float:
    """Between the middles of two sightings, m."""
    return hypot(one.x - other.x, one.y - other.y)


def same(one: Fruit, other: Fruit) -> bool:
    """Whether two sightings are of one fruit."""
    return apart(one, other) < SAME


def _distance(point: Array, start: Array, end: Array) -> float:
    """From a point to a segment, m."""
    along = end - start
    share = float(np.clip((point - start) @ along / (along @ along), 0.0, 1.0))
    return float(np.linalg.norm(point - start - share * along))
