"""Packing from a conveyor: tracking by images, and picks of moving fruit."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import hypot

import numpy as np

from layflat.cell.file.model import Cell, Conveyor
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.order import Fruit, NotPicked, PickChoice, select_pick
from layflat.cell.plan.pick import CellReadings, MovingFruit, PickCommand, PickPhase, PickState, Relocation
from layflat.cell.vision import SURE_CONFIDENCE
from layflat.cell.work.belt_model import BeltModel, FruitTrack
from layflat.cell.work.observer import Observer, Pick
from layflat.cell.work.packer import Packer, centre_fruit, handling_time
from layflat.cell.work.station import CellStation
from layflat.errors import PictureError
from layflat.motion.meeting import MovingTarget, TargetLine
from layflat.motion.planar import Angles, Configuration

IMAGE_PERIOD = 0.1  # s
MAX_BLIND_TIME = 1.5  # without an image of the belt's motion, beyond which nothing on it is picked, s
REST_SPEED = 0.02  # below which a belt counts as at rest, m/s
MIN_SIGHTINGS = 2  # detections of a fruit before it is picked
WAITING_FRACTION, WAITING_DISTANCE = (
    0.3,
    0.08,
)  # where an idle arm waits: share of its reach along the belt, and beside the belt, m


class BeltPacker(Packer):
    """Packer of a cell with a conveyor."""

    def __init__(
        self, cell: Cell, belt: Conveyor, station: CellStation, perception: Perception, observer: Observer
    ) -> None:
        """Begin without tracks, and compute where an idle arm waits."""
        super().__init__(cell, station, perception, observer)
        self._belt, self._perception = belt, perception
        self.model = BeltModel(cell, belt)
        self._track: FruitTrack | None = None  # of the fruit that is being picked
        self._course: MovingTarget | None = None  # and its motion
        self._waiting_angles = {onwards: self._choose_waiting_angles(onwards=onwards) for onwards in (False, True)}
        self._next, self._seen = station.time, station.time  # image, and the last that could be used, s
        self._tried: dict[int, int] = {}  # picks by number of the track
        self._reasons: dict[int, NotPicked] = {}  # why each was not picked so far

    def work(self, max_picks: int) -> Iterator[Pick]:
        """Yield picks of fruit as it comes, until `max_picks`, or without pick or new fruit for the `idle_timeout`.

        Raises PictureError where the camera gives no image that can be used for so long, RigStoppedError as the
        station.
        """
        number, came, deadline = 0, 0, self._station.time + self._belt.idle_timeout
        while number < max_picks and self._station.time < deadline:
            choice = self._choose_moving() if self._take_image() else None
            if choice is not None:
                number += 1
                yield self._pick(number, choice)
            else:
                self._perform(PickCommand(self._waiting(), self._passing, suction=False, image=False))
            if choice is not None or self.model.came > came:
                came, deadline = self.model.came, self._station.time + self._belt.idle_timeout

    def finish(self) -> None:
        """Record why fruit passed by without being picked; the arm stays where it is."""
        self.not_picked = tuple(self._reasons.values())

    def _waiting(self) -> Angles:
        """Return the joint angles at which an idle arm waits; those of its present target while the lift is down."""
        up = self._station.measure().height >= self._passing - self._rules.height
        return self._waiting_angles[self.model.speed > -REST_SPEED] if up else self._station.arm.target

    def _take_image(self) -> bool:
        """Update the model by an image if one is due; return whether one was taken and could be used.

        Raise PictureError where none could be used for the conveyor's `idle_timeout`.
        """
        now = self._station.time
        if now < self._next - 1e-9:
            return False
        self._next += IMAGE_PERIOD
        try:
            observation = self._perception.observe(now)
        except PictureError:
            if now - self._seen > self._belt.idle_timeout:
                raise
            return False
        self._seen = now
        self._observer.on_image(observation)
        self.model.update(observation, self._world.occlusion(self._station.arm.angles))
        if self._track is not None:
            self._course = self._estimated_motion(self._track) or self._course
        return True

    def _estimated_motion(self, track: FruitTrack) -> MovingTarget | None:
        """Return the estimated motion of a fruit from now on; None where its line misses the arm's reach."""
        lane, now = self._lane(track.across), self._station.time
        if lane.path is None:
            return None
        return MovingTarget(lane, self.model.position_along(track, now) + self._belt.size[0] / 2, now, self.model.speed)

    def _choose_waiting_angles(self, *, onwards: bool) -> Angles:
        """Return joint angles beside the belt, on the side of the arm's base; home where none is within reach.

        They are near the begin of the reach of a belt that runs `onwards`, else near its end.
        """
        length, half = self._belt.size[0], self._belt.size[1] / 2 + WAITING_DISTANCE
        middle = self._lane(0.0)
        fraction = WAITING_FRACTION if onwards else 1.0 - WAITING_FRACTION
        along = middle.low + fraction * (middle.high - middle.low) - length / 2
        points = self._belt.to_cell_frame(np.array([[along, half], [along, -half]])).tolist()
        x, y = min(points, key=lambda point: hypot(*point))
        configuration = self._reach.choose_configuration(x, y, lambda angles: max(map(abs, angles)))
        return configuration.angles if configuration is not None else self._rules.clear

    def _lane(self, across: float) -> TargetLine:
        """Return the line along which fruit at a distance (m) from the belt's middle moves."""
        length = self._belt.size[0]
        x, y = self._belt.to_cell_frame(np.array([[-length / 2, across]]))[0].tolist()
        return TargetLine(self._reach, (x, y), self._belt.rotation, length)

    def _choose_moving(self) -> PickChoice | None:
        """Choose the fruit on the belt to pick next: the surest (to 0.1), of these the first to leave the reach.

        Keep its track and motion for the pick, and the reasons against the others.
        Return None while the belt's speed is unknown, the last image is too old, or no fruit can be met in time.
        """
        now = self._station.time
        if now - self.model.seen_at > MAX_BLIND_TIME or not self.model.is_speed_known:
            return None
        tracks = {self.model.fruit(track, now): track for track in self.model.tracks}
        tried = frozenset(
            fruit for fruit, track in tracks.items() if self._tried.get(track.number, 0) >= self._rules.tries
        )
        plan_fruit = partial(self._plan_moving, tracks)
        selection = select_pick(
            list(tracks), self._cell.cup.diameter / 2, plan_fruit, least_confidence=SURE_CONFIDENCE, given_up=tried
        )
        self._reasons |= {tracks[not_picked.fruit].number: not_picked for not_picked in selection.not_picked}
        if selection.choice is not None:
            self._track = tracks[selection.choice.fruit]
            self._course = self._estimated_motion(self._track)
        return selection.choice

    def _plan_moving(self, tracks: dict[Fruit, FruitTrack], fruit: Fruit) -> PickChoice | str:
        """Return the pick of a fruit on the belt, with the time until it leaves the reach; or the reason against it."""
        track, now = tracks[fruit], self._station.time
        place, course = self.packing.best_place(fruit), self._estimated_motion(track)
        if place is None:
            return self.packing.refusal_reason(fruit)
        if course is None:
            return "does not come within reach"
        if track.images < MIN_SIGHTINGS:
            return "has just come in sight"
        meeting = self._station.arm.meeting(course)
        if meeting is None or course.braking_time - meeting.time < handling_time(self._cell, fruit):
            gone = course.braking_time - now < handling_time(self._cell, fruit)
            return "leaves the reach before it could be picked" if gone else "is not within reach yet"
        over = tuple(course.states(np.array([meeting.time])).angles[0].tolist())
        over_place = self._reach.choose_configuration(
            place.x, place.y, lambda angles: float(np.ptp(np.subtract(angles, over)))
        )
        if over_place is None:
            return f"its place {place.name} of {place.container} is out of reach"
        return PickChoice(fruit, Configuration(over, 0.0), place, over_place, min(course.braking_time - now, 1e3))

    def _pick(self, number: int, choice: PickChoice) -> Pick:
        """Pick the chosen fruit as `Packer` does, count the attempt, and end its pursuit."""
        assert self._track is not None  # it was chosen
        track = self._track
        self._reasons.pop(track.number, None)
        pick = super()._pick(number, choice)
        self._tried[track.number] = self._tried.get(track.number, 0) + 1
        self._track = self._course = None
        return pick

    def _sighting(self, choice: PickChoice) -> tuple[Observation, Fruit]:  # noqa: ARG002  (as of all packers)
        assert self._track is not None  # it was chosen
        return self._track.observation, self._track.fruit

    def _measure(self, relocation: Relocation | None = None) -> CellReadings:
        return replace(self._station.measure(relocation), moving=self._picked_fruit_motion())

    def _picked_fruit_motion(self) -> MovingFruit | None:
        """Return the estimate of the picked fruit's motion now, with the reason why it can't be followed, if any.

        Return None where no fruit is being picked. Before it is within reach the arm is held; with a reason it goes to
        the end of the reach.
        """
        track, course, now = self._track, self._course, self._station.time
        if track is None or course is None:
            return None
        trouble = ""
        if course.braking_time <= now:
            trouble = "it left the arm's reach"
        elif track in self.model.lost:
            trouble = "it was lost from sight"
        elif now - self.model.seen_at > MAX_BLIND_TIME:
            trouble = f"the belt was not seen for {MAX_BLIND_TIME:.1f} s"
        still = (0.0,) * len(self._station.arm.angles)
        if trouble:
            return MovingFruit(tuple(course.end_angles.tolist()), still, trouble)
        if course.entry_time > now:
            return MovingFruit(self._station.arm.angles, still)  # it can't be there yet
        over = course.state(now)
        return MovingFruit(tuple(over.angles.tolist()), tuple(over.velocities.tolist()))

    def _perform(self, command: PickCommand) -> None:
        """Advance the station by a control cycle, and during a pick take an image if one is due."""
        self._station.advance(command, self._course if command.follow else None)
        if self._track is not None:
            self._take_image()

    def _follow(self, choice: PickChoice, before: PickState, after: PickState) -> PickState:
        """Return the state after a change of phase: a sealed fruit corrects the task; carried fruit is not tracked."""
        angles, track = self._station.arm.angles, self._track
        assert track is not None  # it is being picked
        match before.phase, after.phase:
            case PickPhase.SEAL, PickPhase.LIFT:
                fruit = self.model.fruit(track, self._station.time)
                return replace(after, task=centre_fruit(after.task, fruit, choice.place, angles, self._reach))
            case PickPhase.LIFT, PickPhase.CARRY:
                self.model.forget(track)
        return after


def make_packer(cell: Cell, station: CellStation, perception: Perception, observer: Observer) -> Packer:
    """Return the packer of a cell: of its trays, or of its conveyor.

    Args:
        cell: description.
        station: arm, lift and cup.
        perception: source of observations.
        observer: notified of each pick's events.
    """
    if cell.conveyor is None:
        return Packer(cell, station, perception, observer)
    return BeltPacker(cell, cell.conveyor, station, perception, observer)
