"""What the cell knows of its table: what images showed, and, of what the arm hid in them, what was known before.

| symbol | meaning | unit |
|---|---|---|
| C | position of the camera | m |
| P | middle of a fruit | m |
| h | height of the arm's links | m |

The arm hides a fruit if the line of sight C P passes the links, or what hangs from the tip, by less than their radius
and the fruit's apparent radius at that height: r (C_z - h) / (C_z - P_z).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from layflat.arrays import Array
from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.containers import Fruit
from layflat.cell.work.observer import Observer
from layflat.errors import PictureError
from layflat.motion.reach import Angles, Reach

SAME = 15e-3  # two detections nearer than this are of one fruit, m: no two fit there
HANGING = 0.05  # radius of what hangs from the tip, m: lift, cup and the largest fruit


@dataclass(frozen=True)
class OcclusionModel:
    """What the arm hides from a camera while it is still."""

    camera: Array  # its position, (3,) m
    joints: Array  # axes of the joints and the tip, in order, (n + 1, 2) m
    height: float  # of the links' middle, m
    radius: float  # of the links with their drums, m
    half_height: float  # of the links, m

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
        at: Array = self.camera[:2] + share * (np.array([fruit.x, fruit.y]) - self.camera[:2])
        return at, share * fruit.radius


class WorldModel:
    """Takes images of the table, gives the observations to an observer, and knows what lies there."""

    def __init__(self, cell: Cell, perception: Perception, reach: Reach, observer: Observer) -> None:
        self._cell, self._perception, self._reach, self._observer = cell, perception, reach, observer
        self.known: list[Fruit] = []  # what lies on the table, as far as was observed
        self.seen_in: dict[Fruit, Observation] = {}  # the last observation of each of these

    @property
    def in_trays(self) -> list[Fruit]:
        """What can be picked, as far as its place goes."""
        return [fruit for fruit in self.known if self._cell.tray_at(fruit.x, fruit.y) is not None]

    @property
    def outside(self) -> list[Fruit]:
        """What lies neither in a tray nor in a container."""
        inside = self.in_trays
        return [fruit for fruit in self.known if fruit not in inside and self._cell.place_at(fruit.x, fruit.y) is None]

    def update(self, time: float, arm: Angles | None) -> None:
        """Take an image at a time (s), with the arm at its angles (rad), None where it is out of view.

        Raises PictureError where it can't be used; all that was known is known still.
        """
        observation = self._perception.observe(time)
        occlusion = self.occlusion(arm) if arm is not None else None
        self.known = remembered(self.known, observation.fruits, occlusion)
        # What is remembered is the very same fruit as in the observation that showed it.
        self.seen_in = {fruit: self.seen_in.get(fruit, observation) for fruit in self.known}
        self._observer.observed(observation)

    def updated(self, time: float, arm: Angles | None) -> bool:
        """Take an image; return whether it could be used."""
        try:
            self.update(time, arm)
        except PictureError:
            return False
        return True

    def forget(self, fruit: Fruit) -> None:
        """Drop a fruit that was picked up."""
        self.known = [other for other in self.known if other != fruit]

    def occlusion(self, arm: Angles) -> OcclusionModel:
        """Return what the arm hides with its joints at angles, rad."""
        joints = self._cell.machine.joints.values()
        radius = max(joint.cylinder.diameter for joint in joints) / 2
        half_height = max(joint.body.height for joint in joints) / 2
        axes = np.array(self._reach.axes(arm))
        return OcclusionModel(self._perception.position, axes, self._cell.mount.height, radius, half_height)


def remembered(before: Sequence[Fruit], seen: Sequence[Fruit], occlusion: OcclusionModel | None) -> list[Fruit]:
    """Return what lies on the table by now: all that is seen in the open, and what was known of what the arm hides."""
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
