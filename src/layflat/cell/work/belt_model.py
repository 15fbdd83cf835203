"""Model of the conveyor: motion of the belt, and positions of the fruit on it.

| symbol | meaning | unit |
|---|---|---|
| w, v | travel and speed of the belt | m, m/s |
| u_i | constant position of a fruit on the belt: it is detected at u_i + w | m |

All fruit rides the same belt, so one Kalman filter estimates w and v from all detections, also for fruit that the arm
hides. The belt's acceleration is modelled as white noise, of a small intensity or that of a parabola through the last
images; where an image contradicts the model, the speed counts as unknown again.
"""

from collections import deque
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from layflat.cell.file.model import Cell, Conveyor
from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit
from layflat.cell.work.world_model import OcclusionModel

POSITION_ERROR = 0.5e-3  # of a fruit in an image, standard deviation, m
ACCELERATION_NOISE = 0.05  # of a belt of constant speed, standard deviation, m/s2
OUTLIER_SIGMAS = 4.0  # standard deviations of an innovation beyond which the speed has changed
TREND_IMAGES, STEADY_ACCELERATION = (
    6,
    0.1,
)  # last images, by which a belt accelerates less than this that is trusted to go on, m/s2
INITIAL_SPEED_ERROR = 0.3  # of a belt that was not observed yet, standard deviation, m/s
MIN_GATE, MAX_GATE = 0.02, 0.1  # lower and upper limit of the allowed distance of a fruit from its expected position, m
ROLLING_GAIN = 0.1  # of the correction of a fruit's position on the belt
AVERAGED_IMAGES = 10  # over which a fruit's distance from the belt's middle is averaged
MAX_SPEED_ERROR = 8e-3  # standard deviation of the speed up to which hidden fruit may be picked, m/s
MAX_MISSES = 3  # consecutive images without a fruit in view, after which it is lost
END_MARGIN = 0.02  # beyond the end of the belt within which fruit is still tracked, m


@dataclass
class FruitTrack:
    """Track of a fruit on the belt."""

    number: int  # from 1, in the order of their first detections
    fruit: Fruit  # as it was last detected
    position_on_belt: float  # u, along it from its centre, at a travel of 0, m
    across: float  # from the belt's middle, m
    observation: Observation  # last one with the fruit
    images: int = 1  # number of images with the fruit
    missed: int = 0  # number of consecutive images without it, though it was in view


class BeltModel:
    """Kalman filter of the belt's motion, and tracks of its fruit, updated by images."""

    def __init__(self, cell: Cell, belt: Conveyor) -> None:
        """Begin at time 0 without tracks, the speed unknown."""
        self._cell, self._belt = cell, belt
        self._state, self._covariance = np.zeros(2), np.diag([0.0, INITIAL_SPEED_ERROR**2])
        self._time = 0.0
        self.tracks: list[FruitTrack] = []
        self.lost: list[FruitTrack] = []  # no longer detected
        self.came = 0  # number of fruit so far
        # Times, s, and travels of the belt, m, in the last images.
        self._travels = deque[tuple[float, float]](maxlen=TREND_IMAGES)
        self.seen_at = -np.inf  # time of the last image that shows the belt's motion, s

    @property
    def speed(self) -> float:
        """Speed of the belt, m/s."""
        return float(self._state[1])

    @property
    def is_speed_known(self) -> bool:
        """True if the speed is known well enough to pick fruit that the arm hides meanwhile."""
        is_precise = bool(self._covariance[1, 1] < MAX_SPEED_ERROR**2)
        return is_precise and len(self._travels) == TREND_IMAGES and self._acceleration() < STEADY_ACCELERATION

    def position_along(self, track: FruitTrack, time: float) -> float:
        """Return the position of a fruit along the belt, from its centre, at a time (s), m."""
        return float(track.position_on_belt + self._state[0] + self._state[1] * (time - self._time))

    def fruit(self, track: FruitTrack, time: float) -> Fruit:
        """Return a fruit at its estimated position at a time, s."""
        x, y = self._belt.to_cell_frame(np.array([[self.position_along(track, time), track.across]]))[0].tolist()
        return replace(track.fruit, x=x, y=y)

    def forget(self, track: FruitTrack) -> None:
        """Remove the track of a fruit that was picked up."""
        self.tracks = [other for other in self.tracks if other is not track]

    def update(self, observation: Observation, occlusion: OcclusionModel) -> None:
        """Update belt and tracks by an image, with the occlusion by the arm in it.

        A track that was missed in `MAX_MISSES` images moves to `lost`, one beyond the belt's ends is dropped, and a
        detection without a track begins one.
        """
        self._predict(observation.time)
        seen = [one for one in observation.fruits if self._belt.holds(one.x, one.y) and not occlusion.hides(one)]
        pairs, new = self._match(seen)
        self._correct([self._belt.from_centre(fruit.x, fruit.y)[0] - track.position_on_belt for track, fruit in pairs])
        matched = {track.number for track, _ in pairs}
        for track, fruit in pairs:
            along, across = self._belt.from_centre(fruit.x, fruit.y)
            if len(pairs) > 1:  # rolling of a single fruit can't be distinguished from the belt's motion
                track.position_on_belt += ROLLING_GAIN * (along - self.position_along(track, self._time))
            track.across += (across - track.across) / min(track.images + 1, AVERAGED_IMAGES)
            track.fruit, track.observation, track.images, track.missed = fruit, observation, track.images + 1, 0
        for track in self.tracks:
            if track.number not in matched and self._is_visible(track, occlusion):
                track.missed += 1
        self.lost += [track for track in self.tracks if track.missed >= MAX_MISSES]
        end = self._belt.size[0] / 2 + END_MARGIN
        self.tracks = [
            track
            for track in self.tracks
            if track.missed < MAX_MISSES and abs(self.position_along(track, self._time)) < end
        ]
        if not self.tracks:  # the origin of the belt's travel is arbitrary: the next fruit sets it
            self._covariance = np.diag([0.0, self._covariance[1, 1]])
            self._travels.clear()
        for fruit in new:
            along, across = self._belt.from_centre(fruit.x, fruit.y)
            self.came += 1
            self.tracks.append(FruitTrack(self.came, fruit, along - float(self._state[0]), across, observation))

    def _predict(self, time: float) -> None:
        """Advance the estimate of the belt's travel and speed, with its covariance, to a time, s."""
        h, self._time = time - self._time, time
        deviation = max(ACCELERATION_NOISE, self._acceleration())
        transition, noise = np.array([[1.0, h], [0.0, 1.0]]), np.array([h**2 / 2, h])
        self._state = transition @ self._state
        self._covariance = transition @ self._covariance @ transition.T + deviation**2 * np.outer(noise, noise)

    def _acceleration(self) -> float:
        """Return the magnitude of the belt's acceleration over the last images, m/s2; 0 while they are too few."""
        if len(self._travels) < TREND_IMAGES:
            return 0.0
        times, travels = np.array(self._travels).T
        return 2.0 * abs(float(np.polyfit(times - times[-1], travels, 2)[0]))

    def _match(self, seen: list[Fruit]) -> tuple[list[tuple[FruitTrack, Fruit]], list[Fruit]]:
        """Return pairs of track and fruit within the gate, nearest first, and the fruit without a track."""
        gate = min(MIN_GATE + OUTLIER_SIGMAS * sqrt(self._covariance[0, 0]), MAX_GATE)
        candidates = [(track, fruit) for track in self.tracks for fruit in seen if self._distance(track, fruit) < gate]
        candidates.sort(key=lambda pair: self._distance(*pair))
        pairs: list[tuple[FruitTrack, Fruit]] = []
        for track, fruit in candidates:
            if all(track is not other and fruit is not paired_fruit for other, paired_fruit in pairs):
                pairs.append((track, fruit))
        paired = [fruit for _, fruit in pairs]
        return pairs, [fruit for fruit in seen if not any(fruit is paired_fruit for paired_fruit in paired)]

    def _distance(self, track: FruitTrack, fruit: Fruit) -> float:
        """Return the distance of a detection from the position that its track has now, m."""
        expected = self.fruit(track, self._time)
        return float(np.hypot(fruit.x - expected.x, fruit.y - expected.y))

    def _correct(self, travels: list[float]) -> None:
        """Correct travel and speed by the median of the belt's travels (m) as each fruit shows them; nothing for none.

        Where it contradicts the estimate, the speed counts as unknown again.
        """
        if not travels:
            return
        self.seen_at = self._time
        innovation, error = float(np.median(travels) - self._state[0]), POSITION_ERROR**2 / len(travels)
        if innovation**2 > OUTLIER_SIGMAS**2 * (self._covariance[0, 0] + error):
            self._covariance += np.diag([innovation**2, INITIAL_SPEED_ERROR**2])
            self._covariance[0, 1] = self._covariance[1, 0] = 0.5 * sqrt(
                self._covariance[0, 0] * self._covariance[1, 1]
            )
            self._travels.clear()
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + error)
        self._travels.append((self._time, float(np.median(travels))))
        self._state = self._state + gain * innovation
        self._covariance = self._covariance - np.outer(gain, self._covariance[0])

    def _is_visible(self, track: FruitTrack, occlusion: OcclusionModel) -> bool:
        """Return whether a fruit is on the belt, inside the picture, and not hidden by the arm."""
        fruit = self.fruit(track, self._time)
        return (
            self._belt.holds(fruit.x, fruit.y)
            and self._cell.camera.sees((fruit.x, fruit.y))
            and not occlusion.hides(fruit)
        )
