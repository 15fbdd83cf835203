"""Model of the table: detected fruit, and remembered fruit at positions that the arm hid in the last image.

| symbol | meaning | unit |
|---|---|---|
| C | position of the camera | m |
| P | middle of a fruit | m |
| h | height of the arm's links | m |

The arm hides a fruit if the line of sight C P passes the links, or the tool at the tip, by less than the sum of their
radius and the fruit's apparent radius at that height: r (C_z - h) / (C_z - P_z).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from layflat.arrays import Array
from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.order import Fruit
from layflat.cell.work.observer import Observer
from layflat.errors import PictureError
from layflat.motion.planar import Angles, PlanarReach

SAME_DISTANCE = 15e-3  # of two detections below which they are of one fruit, m: two fruit do not fit there
TOOL_RADIUS = 0.05  # of lift, cup and the largest fruit at the tip, m


@dataclass(frozen=True)
class OcclusionModel:
    """Model of the occlusion by a stationary arm in the camera's view."""

    camera: Array  # its position, (3,) m
    joints: Array  # axes of the joints and the tip, in order, (n + 1, 2) m
    height: float  # of the links' middle, m
    radius: float  # of the links with their drums, m
    half_height: float  # of the links, m

    def hides(self, fruit: Fruit) -> bool:
        """Return whether any part of a fruit is hidden."""
        low, high = self.height - self.half_height, self.height + self.half_height
        for height in np.linspace(low, high, 3).tolist():
            at, radius = self._apparent(fruit, height)
            links = zip(self.joints[:-1], self.joints[1:], strict=True)
            if min(_distance(at, a, b) for a, b in links) < self.radius + radius:
                return True
        for height in np.linspace(0.0, self.height, 5).tolist():
            at, radius = self._apparent(fruit, max(height, fruit.radius))
            if float(np.linalg.norm(at - self.joints[-1])) < TOOL_RADIUS + radius:
                return True
        return False

    def _apparent(self, fruit: Fruit, height: float) -> tuple[Array, float]:
        """Return the line of sight's point at a height, (2,) m, and the fruit's apparent radius there."""
        share = (self.camera[2] - height) / (self.camera[2] - fruit.radius)
        at: Array = self.camera[:2] + share * (np.array([fruit.x, fruit.y]) - self.camera[:2])
        return at, share * fruit.radius


class WorldModel:
    """Model of the table, updated by images, whose observations are passed to an observer."""

    def __init__(self, cell: Cell, perception: Perception, reach: PlanarReach, observer: Observer) -> None:
        self._cell, self._perception, self._reach, self._observer = cell, perception, reach, observer
        self.known: list[Fruit] = []  # on the table, as observed
        self.seen_in: dict[Fruit, Observation] = {}  # last observation of each known fruit

    @property
    def in_trays(self) -> list[Fruit]:
        """Fruit that lies in a tray."""
        return [fruit for fruit in self.known if self._cell.tray_at(fruit.x, fruit.y) is not None]

    @property
    def outside(self) -> list[Fruit]:
        """Fruit that lies neither in a tray nor in a container."""
        inside = self.in_trays
        return [fruit for fruit in self.known if fruit not in inside and self._cell.place_at(fruit.x, fruit.y) is None]

    def update(self, time: float, arm: Angles | None) -> None:
        """Update the model by an image at a time (s), with the arm's joint angles (rad), None where it is out of view.

        Raise PictureError where the image can't be used; the model is unchanged then.
        """
        observation = self._perception.observe(time)
        occlusion = self.occlusion(arm) if arm is not None else None
        self.known = update_fruit(self.known, observation.fruits, occlusion)
        # Remembered fruit is the same object as in the observation that showed it.
        self.seen_in = {fruit: self.seen_in.get(fruit, observation) for fruit in self.known}
        self._observer.on_image(observation)

    def try_update(self, time: float, arm: Angles | None) -> bool:
        """Update as `update`; return whether the image could be used."""
        try:
            self.update(time, arm)
        except PictureError:
            return False
        return True

    def forget(self, fruit: Fruit) -> None:
        """Remove a picked fruit from `known`."""
        self.known = [other for other in self.known if other != fruit]

    def occlusion(self, arm: Angles) -> OcclusionModel:
        """Return the occlusion by the arm at joint angles, rad."""
        joints = self._cell.machine.joints.values()
        radius = max(joint.cylinder.diameter for joint in joints) / 2
        half_height = max(joint.body.height for joint in joints) / 2
        axes = np.array(self._reach.axes(arm))
        return OcclusionModel(self._perception.position, axes, self._cell.mount.height, radius, half_height)


def update_fruit(before: Sequence[Fruit], seen: Sequence[Fruit], occlusion: OcclusionModel | None) -> list[Fruit]:
    """Return the fruit on the table: detections that are not hidden, and remembered fruit that is.

    Args:
        before: fruit known before.
        seen: detections in the new image.
        occlusion: occlusion by the arm in that image; None: it hides nothing.
    """
    if occlusion is None:
        return list(seen)
    visible = [fruit for fruit in seen if not occlusion.hides(fruit)]
    hidden = [
        known for known in before if occlusion.hides(known) and not any(is_same_fruit(known, new) for new in visible)
    ]
    return visible + hidden


def fruit_distance(first: Fruit, second: Fruit) -> float:
    """Return the distance between the middles of two detections, m."""
    return hypot(first.x - second.x, first.y - second.y)


def is_same_fruit(first: Fruit, second: Fruit) -> bool:
    """Return whether two detections are of one fruit: nearer than `SAME_DISTANCE`, of whatever kinds."""
    return fruit_distance(first, second) < SAME_DISTANCE


def _distance(point: Array, start: Array, end: Array) -> float:
    """Return the distance of a point to a segment, m."""
    along = end - start
    share = float(np.clip((point - start) @ along / (along @ along), 0.0, 1.0))
    return float(np.linalg.norm(point - start - share * along))
