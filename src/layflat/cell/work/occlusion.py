"""Which fruit the arm hides in an image, so that what was known of it is remembered.

| symbol | meaning | unit |
|---|---|---|
| C | position of the camera | m |
| P | middle of a fruit | m |
| h | height of the arm's links | m |

The arm hides a fruit if the line of sight C P passes the links, or what hangs from the tip, by less than their radius
and the fruit's apparent radius at that height: r (C_z - h) / (C_z - P_z).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from layflat.cell.geometry import Array
from layflat.cell.plan.fruit import Fruit

SAME = 15e-3
"""Two detections nearer than this are of one fruit, m: no two fit there."""

HANGING = 0.05
"""Radius of what hangs from the tip, m: lift, cup and the largest fruit."""


@dataclass(frozen=True)
class OcclusionModel:
    """What the arm hides from a camera while it is still.

    Args:
        camera: its position, (3,) m.
        joints: axes of the joints and the tip, in order, (n + 1, 2) m.
        height: of the links' middle, m.
        radius: of the links with their drums, m.
        half_height: of the links, m.
    """

    camera: Array
    joints: Array
    height: float
    radius: float
    half_height: float

    def hides(self, fruit: Fruit) -> bool:
        """Return whether any of a fruit is hidden."""
        low, high = self.height - self.half_height, self.height + self.half_height
        for height in np.linspace(low, high, 3).tolist():
            at, radius = self._apparent(fruit, height)
            links = zip(self.joints[:-1], self.joints[1:], strict=True)
            if min(_distance(at, a, b) for a, b in links) < self.radius + radius:
                return True
        for height in np.linspace(0.0, self.height, 5).tolist():
            at, radius = self._apparent(fruit, max(height, fruit.radius))
            if float(np.linalg.norm(at - self.joints[-1])) < HANGING + radius:
                return True
        return False

    def _apparent(self, fruit: Fruit, height: float) -> tuple[Array, float]:
        """Return where the line of sight passes a height (2,), m, and the fruit's apparent radius there."""
        share = (self.camera[2] - height) / (self.camera[2] - fruit.radius)
        middle = np.array([fruit.x, fruit.y])
        at: Array = self.camera[:2] + share * (middle - self.camera[:2])
        return at, share * fruit.radius


def remembered(before: Sequence[Fruit], seen: Sequence[Fruit], occlusion: OcclusionModel | None) -> list[Fruit]:
    """Return what lies on the table by now: all that is in the open, and what was known of what the arm hides.

    Args:
        before: what was known.
        seen: in a new image.
        occlusion: by the arm in that image; None where it is out of view.
    """
    if occlusion is None:
        return list(seen)
    in_the_open = [fruit for fruit in seen if not occlusion.hides(fruit)]
    hidden = [one for one in before if occlusion.hides(one) and not any(same(one, new) for new in in_the_open)]
    return in_the_open + hidden


def apart(one: Fruit, other: Fruit) -> float:
    """Return the distance between the middles of two detections, m."""
    return hypot(one.x - other.x, one.y - other.y)


def same(one: Fruit, other: Fruit) -> bool:
    """Return whether two detections are of one fruit."""
    return apart(one, other) < SAME


def _distance(point: Array, start: Array, end: Array) -> float:
    """Return the distance of a point to a segment, m."""
    along = end - start
    share = float(np.clip((point - start) @ along / (along @ along), 0.0, 1.0))
    return float(np.linalg.norm(point - start - share * along))
