"""What the cell knows of its conveyor: how the belt moves, and which fruit lies where on it.

| symbol | meaning | unit |
|---|---|---|
| w, v | way and speed of the belt | m, m/s |
| u_i | place of a fruit on the belt, which does not move: it is seen at u_i + w | m |

All fruit rides the same belt, so one Kalman filter estimates w and v from all that is seen: what an arm hides is led
on by what it does not. The belt's acceleration is taken for white noise, little of it, or as much as a parabola through
the last images shows; where an image contradicts that, the speed is taken as unknown again.
"""

from collections import deque
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from layflat.cell.file.conveyor import Conveyor
from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit
from layflat.cell.work.world_model import OcclusionModel

SEEN = 0.5e-3  # error of a fruit's place in an image, standard deviation, m
ROUGH = 0.05  # acceleration of the belt while its speed is constant, standard deviation, m/s2
UNLIKELY = 4.0  # standard deviations beyond which the speed has changed
IMAGES, STEADY = 6, 0.1  # last images, by which a belt accelerates less than this that is trusted to go on, m/s2
UNKNOWN = 0.3  # speed of a belt that has not been seen to move, standard deviation, m/s
NEAREST, FURTHEST = 0.02, 0.1  # between which lies how far a fruit may be from where it is expected, m
ROLLED = 0.1  # share of what a fruit was seen beside its place on the belt by which that is corrected
LATEST = 10  # images over which its distance from the belt's middle is averaged
SURE_SPEED = 8e-3  # error of the speed with which what is hidden is known well enough, standard deviation, m/s
MISSES = 3  # images in a row, in which a fruit should have been, after which it is lost from sight
OFF = 0.02  # beyond the end of the belt, m


@dataclass
class Track:
    """A fruit on the belt."""

    number: int  # from 1, in the order in which they came in sight
    fruit: Fruit  # as it was last detected
    place: float  # on the belt: where it would be with w = 0, from the belt's centre, m
    across: float  # from the belt's middle, m
    observation: Observation  # the last one with it
    seen: int = 1  # images
    missed: int = 0  # images in a row in which it should have been


class BeltModel:
    """Follows the belt from image to image."""

    def __init__(self, cell: Cell, belt: Conveyor) -> None:
        self._cell, self._belt = cell, belt
        self._state, self._spread = np.zeros(2), np.diag([0.0, UNKNOWN**2])
        self._time = 0.0
        self.tracks: list[Track] = []
        self.lost: list[Track] = []  # from sight
        self.came = 0  # fruit so far
        self._ways = deque[tuple[float, float]](maxlen=IMAGES)  # times, s, and ways of the belt in the last images, m
        self.seen_at = -np.inf  # when an image last showed how the belt moves, s

    @property
    def speed(self) -> float:
        """Speed of the belt, m/s."""
        return float(self._state[1])

    @property
    def sure(self) -> bool:
        """True if the speed is known well enough to pick what the arm hides meanwhile."""
        known = bool(self._spread[1, 1] < SURE_SPEED**2)
        return known and len(self._ways) == IMAGES and self._acceleration() < STEADY

    def along(self, track: Track, time: float) -> float:
        """Return how far a fruit is from the belt's centre at a time (s), m."""
        return float(track.place + self._state[0] + self._state[1] * (time - self._time))

    def fruit(self, track: Track, time: float) -> Fruit:
        """Return a fruit where it is at a time, s."""
        x, y = self._belt.placed(np.array([[self.along(track, time), track.across]]))[0].tolist()
        return replace(track.fruit, x=x, y=y)

    def forget(self, track: Track) -> None:
        """Drop a fruit that was picked up."""
        self.tracks = [other for other in self.tracks if other is not track]

    def update(self, observation: Observation, occlusion: OcclusionModel) -> None:
        """Take in an image, with what the arm hid in it."""
        self._predict(observation.time)
        seen = [one for one in observation.fruits if self._belt.holds(one.x, one.y) and not occlusion.hides(one)]
        pairs, new = self._matched(seen)
        self._correct([self._belt.from_centre(fruit.x, fruit.y)[0] - track.place for track, fruit in pairs])
        matched = {track.number for track, _ in pairs}
        for track, fruit in pairs:
            along, across = self._belt.from_centre(fruit.x, fruit.y)
            if len(pairs) > 1:  # one alone shows how the belt moves, and not whether it rolls
                track.place += ROLLED * (along - self.along(track, self._time))
            track.across += (across - track.across) / min(track.seen + 1, LATEST)
            track.fruit, track.observation, track.seen, track.missed = fruit, observation, track.seen + 1, 0
        for track in self.tracks:
            if track.number not in matched and self._in_the_open(track, occlusion):
                track.missed += 1
        self.lost += [track for track in self.tracks if track.missed >= MISSES]
        end = self._belt.size[0] / 2 + OFF
        self.tracks = [
            track for track in self.tracks if track.missed < MISSES and abs(self.along(track, self._time)) < end
        ]
        if not self.tracks:  # the belt's way counts from anywhere: what comes first says from where
            self._spread = np.diag([0.0, self._spread[1, 1]])
            self._ways.clear()
        for fruit in new:
            along, across = self._belt.from_centre(fruit.x, fruit.y)
            self.came += 1
            self.tracks.append(Track(self.came, fruit, along - float(self._state[0]), across, observation))

    def _predict(self, time: float) -> None:
        h, self._time = time - self._time, time
        rough = max(ROUGH, self._acceleration())
        onwards, noise = np.array([[1.0, h], [0.0, 1.0]]), np.array([h**2 / 2, h])
        self._state = onwards @ self._state
        self._spread = onwards @ self._spread @ onwards.T + rough**2 * np.outer(noise, noise)

    def _acceleration(self) -> float:
        """Return how much the belt accelerated or braked over the last images, m/s2; zero while they are few."""
        if len(self._ways) < IMAGES:
            return 0.0
        times, ways = np.array(self._ways).T
        return 2.0 * abs(float(np.polyfit(times - times[-1], ways, 2)[0]))

    def _matched(self, seen: list[Fruit]) -> tuple[list[tuple[Track, Fruit]], list[Fruit]]:
        """Return each fruit with the track that it belongs to, nearest first, and those that are new."""
        gate = min(NEAREST + UNLIKELY * sqrt(self._spread[0, 0]), FURTHEST)
        found = [(track, fruit) for track in self.tracks for fruit in seen if self._off(track, fruit) < gate]
        found.sort(key=lambda pair: self._off(*pair))
        pairs: list[tuple[Track, Fruit]] = []
        for track, fruit in found:
            if all(track is not other and fruit is not one for other, one in pairs):
                pairs.append((track, fruit))
        taken = [fruit for _, fruit in pairs]
        return pairs, [fruit for fruit in seen if not any(fruit is one for one in taken)]

    def _off(self, track: Track, fruit: Fruit) -> float:
        expected = self.fruit(track, self._time)
        return float(np.hypot(fruit.x - expected.x, fruit.y - expected.y))

    def _correct(self, ways: list[float]) -> None:
        """Correct way and speed by the ways of the belt that the fruit shows."""
        if not ways:
            return
        self.seen_at = self._time
        surprise, error = float(np.median(ways) - self._state[0]), SEEN**2 / len(ways)
        if surprise**2 > UNLIKELY**2 * (self._spread[0, 0] + error):
            self._spread += np.diag([surprise**2, UNKNOWN**2])
            self._spread[0, 1] = self._spread[1, 0] = 0.5 * sqrt(self._spread[0, 0] * self._spread[1, 1])
            self._ways.clear()
        gain = self._spread[:, 0] / (self._spread[0, 0] + error)
        self._ways.append((self._time, float(np.median(ways))))
        self._state = self._state + gain * surprise
        self._spread = self._spread - np.outer(gain, self._spread[0])

    def _in_the_open(self, track: Track, occlusion: OcclusionModel) -> bool:
        fruit = self.fruit(track, self._time)
        return (
            self._belt.holds(fruit.x, fruit.y)
            and self._cell.camera.sees((fruit.x, fruit.y))
            and not occlusion.hides(fruit)
        )
