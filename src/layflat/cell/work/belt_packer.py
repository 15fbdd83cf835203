"""Packs what comes on a conveyor: follows the belt by images, meets a fruit on its way, picks it, and looks again."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import hypot

import numpy as np

from layflat.cell.file.conveyor import Conveyor
from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.containers import Fruit
from layflat.cell.plan.order import Choice, NotPicked, selected
from layflat.cell.plan.pick import Command, Moving, Phase, Readings, Relocation, State
from layflat.cell.vision import SURE
from layflat.cell.work.belt_model import BeltModel, Track
from layflat.cell.work.observer import Observer
from layflat.cell.work.packer import Packer
from layflat.cell.work.records import Pick
from layflat.cell.work.station import Station
from layflat.cell.work.tasks import centred, handling_time
from layflat.errors import PictureError
from layflat.motion.meeting import Course, Lane
from layflat.motion.reach import Angles, Posture

EVERY = 0.1  # between two images, s
BLIND = 1.5  # without an image that shows how the belt moves, after which nothing on it is picked, s
SLOW = 0.02  # speed below which a belt may as well rest, m/s
TRUSTED = 2  # images of a fruit before it is picked
UPSTREAM, BESIDE = 0.3, 0.08  # where an idle arm waits: share of its reach along the belt, and beside the belt, m


class BeltPacker(Packer):
    """What decides in a cell with a conveyor."""

    def __init__(
        self, cell: Cell, belt: Conveyor, station: Station, perception: Perception, observer: Observer
    ) -> None:
        super().__init__(cell, station, perception, observer)
        self._belt, self._perception = belt, perception
        self.model = BeltModel(cell, belt)
        self._track: Track | None = None  # what is being picked
        self._course: Course | None = None  # and where it goes
        self._aside = {onwards: self._place_to_wait(onwards=onwards) for onwards in (False, True)}
        self._next, self._seen = station.time, station.time  # image, and the last that could be used, s
        self._tried: dict[int, int] = {}  # picks by number of the track
        self._reasons: dict[int, NotPicked] = {}  # why each was not picked so far

    def work(self, most: int) -> Iterator[Pick]:
        """Pick what comes, until there were so many picks or nothing new has come for the conveyor's patience.

        Raises PictureError where the camera gives no image that can be used for so long, RigStoppedError as the
        station.
        """
        number, came, until = 0, 0, self._station.time + self._belt.patience
        while number < most and self._station.time < until:
            choice = self._choose_moving() if self._look() else None
            if choice is not None:
                number += 1
                yield self._pick(number, choice)
            else:
                self._perform(Command(self._waiting(), self._passing, suction=False, image=False))
            if choice is not None or self.model.came > came:
                came, until = self.model.came, self._station.time + self._belt.patience

    def finish(self) -> None:
        """Leave the arm where it is: what lies in the containers is known. Tell why the rest passed by."""
        self.not_picked = tuple(self._reasons.values())

    def _waiting(self) -> Angles:
        """Return the posture in which an idle arm waits beside the belt, upstream; where it is with the lift down."""
        up = self._station.measure().height >= self._passing - self._rules.height
        return self._aside[self.model.speed > -SLOW] if up else self._station.arm.target

    def _look(self) -> bool:
        """Take an image if it is time for one; return whether one was taken and could be used."""
        now = self._station.time
        if now < self._next - 1e-9:
            return False
        self._next += EVERY
        try:
            observation = self._perception.observe(now)
        except PictureError:
            if now - self._seen > self._belt.patience:
                raise
            return False
        self._seen = now
        self._observer.observed(observation)
        self.model.update(observation, self._world.occlusion(self._station.arm.angles))
        if self._track is not None:
            self._course = self._course_of(self._track) or self._course
        return True

    def _course_of(self, track: Track) -> Course | None:
        """Return where a fruit goes, as is known by now; None where the arm reaches nothing of its way."""
        lane, now = self._lane(track.across), self._station.time
        if lane.path is None:
            return None
        return Course(lane, self.model.along(track, now) + self._belt.size[0] / 2, now, self.model.speed)

    def _place_to_wait(self, *, onwards: bool) -> Angles:
        """Return a posture beside the belt, on the side of the arm's base; home where it reaches none."""
        length, half = self._belt.size[0], self._belt.size[1] / 2 + BESIDE
        middle = self._lane(0.0)
        share = UPSTREAM if onwards else 1.0 - UPSTREAM
        along = middle.low + share * (middle.high - middle.low) - length / 2
        points = self._belt.placed(np.array([[along, half], [along, -half]])).tolist()
        x, y = min(points, key=lambda point: hypot(*point))
        found = self._reach.choose(x, y, lambda angles: max(map(abs, angles)))
        return found.angles if found is not None else self._rules.clear

    def _lane(self, across: float) -> Lane:
        """Return the way of fruit at a distance from the belt's middle, m."""
        length = self._belt.size[0]
        x, y = self._belt.placed(np.array([[-length / 2, across]]))[0].tolist()
        return Lane(self._reach, (x, y), self._belt.rotation, length)

    def _choose_moving(self) -> Choice | None:
        """Choose what leaves the reach first, of all that can be met and picked before."""
        now = self._station.time
        if now - self.model.seen_at > BLIND or not self.model.sure:
            return None
        tracks = {self.model.fruit(track, now): track for track in self.model.tracks}
        tried = frozenset(
            fruit for fruit, track in tracks.items() if self._tried.get(track.number, 0) >= self._rules.tries
        )
        way = partial(self._way, tracks)
        found = selected(list(tracks), self._cell.cup.diameter / 2, way, least_confidence=SURE, given_up=tried)
        self._reasons |= {tracks[one.fruit].number: one for one in found.not_picked}
        if found.choice is not None:
            self._track = tracks[found.choice.fruit]
            self._course = self._course_of(self._track)
        return found.choice

    def _way(self, tracks: dict[Fruit, Track], fruit: Fruit) -> Choice | str:
        """Return how a fruit on the belt is picked, its time being that until it leaves the reach; or why it is not."""
        track, now = tracks[fruit], self._station.time
        place, course = self.packing.best(fruit), self._course_of(track)
        if place is None:
            return self.packing.refusal(fruit)
        if course is None:
            return "does not come within reach"
        if track.seen < TRUSTED:
            return "has just come in sight"
        meeting = self._station.arm.meeting(course)
        if meeting is None or course.leaves - meeting.time < handling_time(self._cell, fruit):
            gone = course.leaves - now < handling_time(self._cell, fruit)
            return "leaves the reach before it could be picked" if gone else "is not within reach yet"
        over = tuple(course.states(np.array([meeting.time])).angles[0].tolist())
        over_place = self._reach.choose(place.x, place.y, lambda angles: float(np.ptp(np.subtract(angles, over))))
        if over_place is None:
            return f"its place {place.name} of {place.container} is out of reach"
        return Choice(fruit, Posture(over, 0.0), place, over_place, min(course.leaves - now, 1e3))

    def _pick(self, number: int, choice: Choice) -> Pick:
        assert self._track is not None  # it was chosen
        track = self._track
        self._reasons.pop(track.number, None)
        pick = super()._pick(number, choice)
        self._tried[track.number] = self._tried.get(track.number, 0) + 1
        self._track = self._course = None
        return pick

    def _sighting(self, choice: Choice) -> tuple[Observation, Fruit]:  # noqa: ARG002  (as of all packers)
        assert self._track is not None  # it was chosen
        return self._track.observation, self._track.fruit

    def _measure(self, relocation: Relocation | None = None) -> Readings:
        return replace(self._station.measure(relocation), moving=self._moving())

    def _moving(self) -> Moving | None:
        """Return where the fruit is now, with the trouble because of which it can't be followed any longer."""
        track, course, now = self._track, self._course, self._station.time
        if track is None or course is None:
            return None
        trouble = ""
        if course.leaves <= now:
            trouble = "it left the arm's reach"
        elif track in self.model.lost:
            trouble = "it was lost from sight"
        elif now - self.model.seen_at > BLIND:
            trouble = f"the belt was not seen for {BLIND:.1f} s"
        still = (0.0,) * len(self._station.arm.angles)
        if trouble:
            return Moving(tuple(course.stop.tolist()), still, trouble)
        if course.enters > now:
            return Moving(self._station.arm.angles, still)  # it can't be there yet
        over = course.state(now)
        return Moving(tuple(over.angles.tolist()), tuple(over.velocities.tolist()))

    def _perform(self, command: Command) -> None:
        self._station.advance(command, self._course if command.follow else None)
        if self._track is not None:
            self._look()

    def _follow(self, choice: Choice, before: State, after: State) -> State:
        angles, track = self._station.arm.angles, self._track
        assert track is not None  # it is being picked
        match before.phase, after.phase:
            case Phase.SEAL, Phase.LIFT:
                fruit = self.model.fruit(track, self._station.time)
                return replace(after, task=centred(after.task, fruit, choice.place, angles, self._reach))
            case Phase.LIFT, Phase.CARRY:
                self.model.forget(track)
        return after


def packer_of(cell: Cell, station: Station, perception: Perception, observer: Observer) -> Packer:
    """Return what decides in a cell: by trays, or by its conveyor."""
    if cell.conveyor is None:
        return Packer(cell, station, perception, observer)
    return BeltPacker(cell, cell.conveyor, station, perception, observer)
