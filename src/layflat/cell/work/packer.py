"""Packs what lies in the trays: look, choose, pick, look again as the fruit is laid, until nothing is left to pick."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import dist
from typing import Protocol

from layflat.cell.file.model import Cell
from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.order import Choice, Cup, Left, next_pick
from layflat.cell.plan.pick import Command, Outcome, Phase, Sighting, State
from layflat.cell.plan.picks import begun, step
from layflat.cell.plan.reach import Angles, Reach
from layflat.cell.vision.detection import SURE
from layflat.cell.work.eyes import Eyes, Sight
from layflat.cell.work.lookout import Looker, Lookout
from layflat.cell.work.memory import apart, same
from layflat.cell.work.packs import packing_of, spot_at
from layflat.cell.work.station import Station
from layflat.cell.work.tasks import Heights, centred, rules_of

PICTURES, PAUSE = 3, 0.2
"""That are tried one after the other until one can be used, and the time between them, s."""

STRAYED = 30e-3
"""How far a fruit may have rolled when the cup missed it and still be taken for the same, m."""

ASTRAY = "lies beside trays and packs"


@dataclass(frozen=True)
class Pick:
    """One pick, as the cell itself knows it.

    Attributes:
        number: from 1.
        choice: what was to be picked, and where it was to go.
        outcome: how it ended.
        trouble: what went wrong last, as one clause; empty where nothing did.
        tries: how often the cup went down for it.
        begin, end: s.
        air: normal litres.
        sight: the last picture in which it was seen before.
    """

    number: int
    choice: Choice
    outcome: Outcome
    trouble: str
    tries: int
    begin: float
    end: float
    air: float
    sight: Sight


class Witness(Looker, Protocol):
    """Who is told what a packer does."""

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""


class Packer:
    """What decides in a cell; it knows what sensors and pictures tell, and no more.

    Args:
        cell: its description.
        station: its hardware.
        eyes: its camera.
        witnesses: are told what it does.

    Attributes:
        packing: what lies in the packs by now.
        left: what is not picked, and why, when the last choice was made.
    """

    def __init__(self, cell: Cell, station: Station, eyes: Eyes, witnesses: Sequence[Witness] = ()) -> None:
        self._cell, self._station, self._witnesses = cell, station, witnesses
        self._reach = Reach(cell.machine)
        self._lookout = Lookout(cell, eyes, self._reach, witnesses)
        self._rules, self._heights = rules_of(cell, self._reach), Heights(cell)
        self._cup = Cup(cell.cup.diameter / 2)
        self.packing = packing_of(cell)
        self.left: tuple[Left, ...] = ()
        self._given_up: list[Fruit] = []
        self._anew = False
        """Whether the last picture showed everything, and nothing was moved since."""

    def work(self, most: int) -> Iterator[Pick]:
        """Picks, one after the other, until there were so many or nothing can be picked.

        Raises:
            PictureError: the camera gives no picture that can be used.
            RigStoppedError: the rig does not let the arm move.
        """
        self._look_from_home()
        for number in range(1, most + 1):
            choice = self._choose()
            if choice is None and not self._anew:
                self._look_from_home()
                choice = self._choose()
            if choice is None:
                return
            pick = self._pick(number, choice)
            yield pick
            if pick.outcome is Outcome.STUCK:
                return
            if pick.outcome is Outcome.LOST:
                self._look_from_home()  # it may lie anywhere

    def finish(self) -> None:
        """Bring the arm out of sight and take a last picture; an arm that holds something stays where it is."""
        if self._station.measure().vacuum < self._rules.gone:
            self._look_from_home()

    # Choosing

    def _choose(self, only: Fruit | None = None) -> Choice | None:
        """What to pick next, of all or of one."""
        fruits = self._lookout.in_trays
        if only is None:
            passed = {fruit for fruit in fruits if any(same(fruit, other) for other in self._given_up)}
        else:
            passed = {fruit for fruit in fruits if fruit != only}
        order = next_pick(
            fruits, self.packing, self._reach, self._station.arm.angles, self._cup, _way,
            least_confidence=SURE, given_up=frozenset(passed),
        )  # fmt: skip
        if only is None:
            self.left = order.left + tuple(Left(fruit, ASTRAY) for fruit in self._lookout.astray)
        return order.choice

    # Picking

    def _pick(self, number: int, choice: Choice) -> Pick:
        station, sight = self._station, self._lookout.seen_in[choice.fruit]
        begin, air, self._anew = station.time, station.air, False
        state, sighting = begun(self._heights.task(choice), station.measure()), None
        while state.phase is not Phase.DONE:
            before = state
            state, command = step(self._rules, before, station.measure(sighting))
            sighting = None
            if state.phase is not before.phase:
                for witness in self._witnesses:
                    witness.phase(choice, before, state)
                state = self._follow(choice, before, state)
            if command.picture and self._lookout.tried(station.time, arm=None):
                again = self._again(choice.fruit)
                choice = again or choice
                sighting = Sighting(self._heights.task(again) if again else None)
            station.turn(command)
        self._book(choice, state)
        assert state.outcome is not None  # it has ended
        taken = station.air - air
        return Pick(number, choice, state.outcome, state.trouble, state.tried, begin, station.time, taken, sight)

    def _follow(self, choice: Choice, before: State, after: State) -> State:
        """What a new phase asks for beside commands; the state to go on from."""
        angles = self._station.arm.angles
        match before.phase, after.phase:
            case Phase.SUCK, Phase.LIFT:
                task = centred(after.task, choice.fruit, choice.spot.place, angles, self._reach)
                return replace(after, task=task)
            case Phase.LIFT, Phase.CARRY:
                self._lookout.forget(choice.fruit)
            case Phase.RELEASE, Phase.RAISE:
                self._lookout.tried(self._station.time, angles)
        return after

    def _again(self, fruit: Fruit) -> Choice | None:
        """A fruit that was missed, where it lies now, if it still can be picked."""
        alike = [new for new in self._lookout.in_trays if new.kind == fruit.kind and apart(new, fruit) < STRAYED]
        found = min(alike, key=lambda new: apart(new, fruit), default=None)
        return self._choose(found) if found is not None else None

    def _book(self, choice: Choice, state: State) -> None:
        if state.outcome is Outcome.PLACED:
            self.packing = self.packing.filled(choice.spot, choice.fruit)
        elif state.outcome in {Outcome.MISSED, Outcome.STUCK}:
            self._given_up.append(choice.fruit)

    # Looking from home

    def _look_from_home(self) -> None:
        """Look from where the arm hides nothing, and see which places are taken.

        Raises:
            PictureError: no picture can be used.
        """
        arm = None if self._went_home() else self._station.arm.angles
        for _ in range(PICTURES - 1):
            if self._lookout.tried(self._station.time, arm):
                break
            self._wait(PAUSE)
        else:
            self._lookout.look(self._station.time, arm)
        self._anew = True
        for fruit in self._lookout.known:
            spot = spot_at(self._cell, self.packing, fruit)
            if spot is not None and fruit.confidence >= SURE:
                self.packing = self.packing.filled(spot, fruit)

    def _went_home(self) -> bool:
        """Bring the empty arm out of the camera's sight; whether it came there in time."""
        rules, station = self._rules, self._station
        until = station.time + rules.settle_time
        while station.time < until:
            measured = station.measure()
            there = dist(rules.tip(measured.angles), rules.tip(rules.clear)) <= rules.off
            if there and all(abs(v) <= rules.still for v in measured.velocities):
                return True
            up = measured.height >= self._heights.passing - rules.height
            self._turn(rules.clear if up else station.arm.target)
        return False

    def _wait(self, time: float) -> None:
        until = self._station.time + time
        while self._station.time < until:
            self._turn(self._rules.clear)

    def _turn(self, posture: Angles) -> None:
        """A cycle between picks."""
        self._station.turn(Command(posture, self._heights.passing, suction=False, picture=False))


def _way(start: Angles, end: Angles) -> float:
    return max(abs(a - b) for a, b in zip(start, end, strict=True))
