"""Packs what lies in the trays: observe, choose, pick, observe again on release, until nothing is left to pick."""

from collections.abc import Iterator
from dataclasses import replace
from math import dist

from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.containers import Fruit, free_place_at, packing_of
from layflat.cell.plan.order import Choice, NotPicked, next_pick
from layflat.cell.plan.pick import Command, Outcome, Phase, Readings, Relocation, State
from layflat.cell.plan.pick_machine import begun, step
from layflat.cell.vision import SURE
from layflat.cell.work.observer import Observer
from layflat.cell.work.records import Pick
from layflat.cell.work.station import Station
from layflat.cell.work.tasks import centred, passing_height, rules_of, task_of
from layflat.cell.work.world_model import WorldModel, apart, same
from layflat.motion.reach import Angles, Reach

IMAGES, PAUSE = 3, 0.2  # that are tried one after the other until one can be used, and the time between them, s
STRAYED = 30e-3  # how far a fruit may have rolled when the cup missed it and still be taken for the same, m
OUTSIDE = "lies beside trays and containers"


class Packer:
    """What decides in a cell, by its station's sensors and its perception's images, and no more."""

    def __init__(self, cell: Cell, station: Station, perception: Perception, observer: Observer) -> None:
        self._cell, self._station, self._observer = cell, station, observer
        self._reach = Reach(cell.machine)
        self._world = WorldModel(cell, perception, self._reach, observer)
        self._rules, self._passing = rules_of(cell, self._reach), passing_height(cell)
        self.packing = packing_of(cell)  # what lies in the containers by now
        self.not_picked: tuple[NotPicked, ...] = ()  # when the last choice was made
        self._given_up: list[Fruit] = []
        self._current = False  # whether the last image showed everything, and nothing was moved since

    def work(self, most: int) -> Iterator[Pick]:
        """Pick one fruit after the other, until there were so many picks or nothing can be picked.

        Raises PictureError where the camera gives no image that can be used, RigStoppedError as the station.
        """
        self._observe_from_home()
        for number in range(1, most + 1):
            choice = self._choose()
            if choice is None and not self._current:
                self._observe_from_home()
                choice = self._choose()
            if choice is None:
                return
            pick = self._pick(number, choice)
            yield pick
            if pick.outcome is Outcome.STUCK:
                return
            if pick.outcome is Outcome.LOST:
                self._observe_from_home()  # it may lie anywhere

    def finish(self) -> None:
        """Bring the arm out of view and take a last image; an arm that holds something stays where it is."""
        if self._station.measure().vacuum < self._rules.gone:
            self._observe_from_home()

    def _choose(self, only: Fruit | None = None) -> Choice | None:
        """Choose what to pick next, of all or of one."""
        fruits = self._world.in_trays
        tried = {fruit for fruit in fruits if any(same(fruit, other) for other in self._given_up)}
        passed = tried if only is None else set(fruits) - {only}
        selection = next_pick(
            fruits, self.packing, self._reach, self._station.arm.angles, self._cell.cup.diameter / 2,
            lambda start, end: max(abs(a - b) for a, b in zip(start, end, strict=True)),
            least_confidence=SURE, given_up=frozenset(passed),
        )  # fmt: skip
        if only is None:
            self.not_picked = selection.not_picked + tuple(NotPicked(one, OUTSIDE) for one in self._world.outside)
        return selection.choice

    def _pick(self, number: int, choice: Choice) -> Pick:
        station, (observation, lay) = self._station, self._sighting(choice)
        self._observer.chosen(lay, observation)
        begin, air, self._current = station.time, station.air, False
        state, relocation = begun(task_of(self._cell, choice), self._measure()), None
        while state.phase is not Phase.DONE:
            before = state
            state, command = step(self._rules, before, self._measure(relocation))
            relocation = None
            if state.phase is not before.phase:
                self._observer.phase(choice, before, state)
                state = self._follow(choice, before, state)
            if command.image and self._world.updated(station.time, arm=None):
                again = self._again(choice.fruit)
                choice = again or choice
                relocation = Relocation(task_of(self._cell, again) if again else None)
            self._perform(command)
        assert state.outcome is not None  # it has ended
        if state.outcome is Outcome.PLACED:
            self.packing = self.packing.filled(choice.place, choice.fruit)
        elif state.outcome in {Outcome.MISSED, Outcome.STUCK}:
            self._given_up.append(choice.fruit)
        taken = station.air - air
        return Pick(number, choice, state.outcome, state.trouble, state.tried, begin, station.time, taken, observation)

    def _sighting(self, choice: Choice) -> tuple[Observation, Fruit]:
        """Return the last observation in which the chosen fruit was seen, and the fruit as it lay there."""
        return self._world.seen_in[choice.fruit], choice.fruit

    def _measure(self, relocation: Relocation | None = None) -> Readings:
        """Return what the sensors give, and what is known of the fruit that is picked."""
        return self._station.measure(relocation)

    def _perform(self, command: Command) -> None:
        """Go through a cycle."""
        self._station.advance(command)

    def _follow(self, choice: Choice, before: State, after: State) -> State:
        """Do what a new phase asks for beside commands; return the state to go on from."""
        angles = self._station.arm.angles
        match before.phase, after.phase:
            case Phase.SEAL, Phase.LIFT:
                return replace(after, task=centred(after.task, choice.fruit, choice.place, angles, self._reach))
            case Phase.LIFT, Phase.CARRY:
                self._world.forget(choice.fruit)
            case Phase.RELEASE, Phase.RAISE:
                self._world.updated(self._station.time, angles)
        return after

    def _again(self, fruit: Fruit) -> Choice | None:
        """Choose a fruit that was missed again, where it lies now, if it still can be picked."""
        alike = [new for new in self._world.in_trays if new.kind == fruit.kind and apart(new, fruit) < STRAYED]
        found = min(alike, key=lambda new: apart(new, fruit), default=None)
        return self._choose(found) if found is not None else None

    def _observe_from_home(self) -> None:
        """Take an image with the arm where it hides nothing, and note which places are taken."""
        arm = None if self._went_home() else self._station.arm.angles
        for _ in range(IMAGES - 1):
            if self._world.updated(self._station.time, arm):
                break
            until = self._station.time + PAUSE
            while self._station.time < until:
                self._advance(self._rules.clear)
        else:
            self._world.update(self._station.time, arm)
        self._current = True
        for fruit in self._world.known:
            place = free_place_at(self._cell, self.packing, fruit)
            if place is not None and fruit.confidence >= SURE:
                self.packing = self.packing.filled(place, fruit)

    def _went_home(self) -> bool:
        """Bring the empty arm out of the camera's view; return whether it came there in time."""
        rules, station = self._rules, self._station
        until = station.time + rules.settle_time
        while station.time < until:
            measured = station.measure()
            there = dist(rules.tip(measured.angles), rules.tip(rules.clear)) <= rules.off
            if there and all(abs(v) <= rules.still for v in measured.velocities):
                return True
            up = measured.height >= self._passing - rules.height
            self._advance(rules.clear if up else station.arm.target)
        return False

    def _advance(self, posture: Angles) -> None:
        """Go through a cycle between picks."""
        self._perform(Command(posture, self._passing, suction=False, image=False))
