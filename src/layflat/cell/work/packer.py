"""Packs what lies in the trays: look, choose, pick, look again as the fruit is laid, until nothing is left to pick."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import dist
from typing import Protocol

import numpy as np

from layflat.cell.eyes import place_of
from layflat.cell.file.checks import within
from layflat.cell.file.model import Cell
from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.order import Choice, Cup, Left, next_pick
from layflat.cell.plan.pick import Command, Outcome, Phase, Sighting, State
from layflat.cell.plan.picks import begun, step
from layflat.cell.plan.reach import Angles, Reach
from layflat.cell.vision.detection import SURE
from layflat.cell.work.eyes import Eyes, Sight
from layflat.cell.work.memory import Shade, remembered, same
from layflat.cell.work.packs import packing_of, spot_at
from layflat.cell.work.station import Station
from layflat.cell.work.tasks import Heights, centred, rules_of
from layflat.errors import PictureError

LOOKS = 3
"""Pictures that are tried one after the other until one can be used."""

PAUSE = 0.2
"""Between them, s."""

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


class Witness(Protocol):
    """Who is told what a packer does."""

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""

    def looked(self, sight: Sight) -> None:
        """A picture was taken and could be used."""


class Packer:
    """What decides in a cell; it knows what sensors and pictures tell, and no more.

    Args:
        cell: its description.
        station: its hardware.
        eyes: its camera.
        witnesses: are told what it does.

    Attributes:
        packing: what lies in the packs by now.
        known: what lies elsewhere, as far as was seen.
        left: what is not picked, and why, when the last choice was made.
    """

    def __init__(self, cell: Cell, station: Station, eyes: Eyes, witnesses: Sequence[Witness] = ()) -> None:
        self._cell, self._station, self._eyes, self._witnesses = cell, station, eyes, witnesses
        self._reach = Reach(cell.machine)
        self._rules, self._heights = rules_of(cell, self._reach), Heights(cell)
        self._cup = Cup(cell.cup.diameter / 2)
        self.packing = packing_of(cell)
        self.known: list[Fruit] = []
        self.left: tuple[Left, ...] = ()
        self._given_up: list[Fruit] = []
        self._seen_in: dict[Fruit, Sight] = {}
        self._anew = False
        """Whether the last picture showed everything, and nothing was moved since."""

    def work(self, most: int) -> Iterator[Pick]:
        """Picks, one after the other, until there were so many or nothing can be picked.

        Raises:
            PictureError: the camera gives no picture that can be used.
            RigStoppedError: the rig does not let the arm move.
        """
        self._look_clear()
        for number in range(1, most + 1):
            choice = self._choose()
            if choice is None and not self._anew:
                self._look_clear()
                choice = self._choose()
            if choice is None:
                return
            pick = self._pick(number, choice)
            yield pick
            if pick.outcome is Outcome.STUCK:
                return
            if pick.outcome is Outcome.LOST:
                self._look_clear()  # it may lie anywhere

    def finish(self) -> None:
        """Bring the arm out of sight and take a last picture."""
        self._look_clear()

    # Choosing

    def _choose(self, only: Fruit | None = None) -> Choice | None:
        """What to pick next, of all or of one."""
        given_up = {fruit for fruit in self._in_trays() if any(same(fruit, other) for other in self._given_up)}
        if only is not None:
            given_up = {fruit for fruit in self._in_trays() if fruit != only}
        order = next_pick(
            self._in_trays(), self.packing, self._reach, self._station.arm.angles, self._cup, self._way,
            least_confidence=SURE, given_up=frozenset(given_up),
        )  # fmt: skip
        if only is None:
            self.left = order.left + tuple(Left(fruit, ASTRAY) for fruit in self._astray())
        return order.choice

    def _in_trays(self) -> list[Fruit]:
        trays = self._cell.tray.values()
        return [fruit for fruit in self.known if any(within(tray, fruit.x, fruit.y) for tray in trays)]

    def _astray(self) -> list[Fruit]:
        """What lies neither in a tray nor in a pack."""
        inside = self._in_trays()
        return [fruit for fruit in self.known if fruit not in inside and place_of(self._cell, fruit.x, fruit.y) is None]

    @staticmethod
    def _way(start: Angles, end: Angles) -> float:
        return max(abs(a - b) for a, b in zip(start, end, strict=True))

    # Picking

    def _pick(self, number: int, choice: Choice) -> Pick:
        station, sight = self._station, self._seen_in[choice.fruit]
        begin, air, self._anew = station.time, station.air, False
        state, sighting = begun(self._heights.task(choice), station.measure()), None
        while state.phase is not Phase.DONE:
            before = state
            state, command = step(self._rules, before, station.measure(sighting))
            sighting = None
            if state.phase is not before.phase:
                for witness in self._witnesses:
                    witness.phase(choice, before, state)
                if state.phase is Phase.LIFT and before.phase is Phase.SUCK:
                    seated = centred(state.task, choice.fruit, choice.spot.place, station.arm.angles, self._reach)
                    state = replace(state, task=seated)
                self._follow(choice, before.phase, state.phase)
            if command.picture and self._look(shade=None):
                again = self._again(choice.fruit)
                choice = again or choice
                sighting = Sighting(self._heights.task(again) if again else None)
            station.turn(command)
        self._book(choice, state)
        assert state.outcome is not None  # it has ended
        taken = station.air - air
        return Pick(number, choice, state.outcome, state.trouble, state.tried, begin, station.time, taken, sight)

    def _follow(self, choice: Choice, before: Phase, after: Phase) -> None:
        """Keep what is known up to date."""
        if after is Phase.CARRY and before is Phase.LIFT:
            self.known = [fruit for fruit in self.known if not same(fruit, choice.fruit)]
        if before is Phase.RELEASE and after is Phase.RAISE:
            self._look(self._shade())

    def _again(self, fruit: Fruit) -> Choice | None:
        """A fruit that was missed, where it lies now, if it still can be picked."""
        near = [new for new in self._in_trays() if new.kind == fruit.kind and dist(_at(new), _at(fruit)) < STRAYED]
        found = min(near, key=lambda new: dist(_at(new), _at(fruit)), default=None)
        return self._choose(found) if found is not None else None

    def _book(self, choice: Choice, state: State) -> None:
        if state.outcome is Outcome.PLACED:
            self.packing = self.packing.filled(choice.spot, choice.fruit)
        elif state.outcome in {Outcome.MISSED, Outcome.STUCK}:
            self._given_up.append(choice.fruit)

    # Looking

    def _look_clear(self) -> None:
        """Look from where the arm hides nothing.

        Raises:
            PictureError: no picture can be used.
        """
        self._go(self._rules.clear)
        for attempt in range(LOOKS):
            if self._look(None, strict=attempt == LOOKS - 1):
                break
            self._wait(PAUSE)
        self._anew = True
        self._find_taken()

    def _find_taken(self) -> None:
        """A place in which something lies that nobody laid there is taken too."""
        for fruit in self.known:
            spot = spot_at(self._cell, self.packing, fruit)
            if spot is not None and fruit.confidence >= SURE:
                self.packing = self.packing.filled(spot, fruit)

    def _look(self, shade: Shade | None, *, strict: bool = False) -> bool:
        """Take a picture and remember what it shows; whether it could be used."""
        try:
            sight = self._eyes.look(self._station.time)
        except PictureError:
            if strict:
                raise
            return False
        self.known = remembered(self.known, sight.fruits, shade)
        # What is remembered is the very same fruit as in the picture that showed it.
        self._seen_in = {fruit: self._seen_in.get(fruit, sight) for fruit in self.known}
        for witness in self._witnesses:
            witness.looked(sight)
        return True

    def _shade(self) -> Shade:
        machine, mount = self._cell.machine, self._cell.mount
        joints = np.array(self._reach.axes(self._station.arm.angles))
        radius = max(joint.cylinder.diameter for joint in machine.joints.values()) / 2
        tall = max(joint.body.height for joint in machine.joints.values()) / 2
        return Shade(self._eyes.position, joints, mount.height, radius, tall)

    # Moving by itself

    def _go(self, posture: Angles) -> None:
        """Bring the empty arm to a posture; where it does not settle in time, it looks from where it is."""
        rules, station = self._rules, self._station
        until = station.time + rules.settle_time
        while station.time < until:
            measured = station.measure()
            there = dist(rules.tip(measured.angles), rules.tip(posture)) <= rules.off
            if there and all(abs(v) <= rules.still for v in measured.velocities):
                break
            up = measured.height >= self._heights.passing - rules.height
            station.turn(Command(posture if up else measured.angles, self._heights.passing, False, picture=False))

    def _wait(self, time: float) -> None:
        until = self._station.time + time
        while self._station.time < until:
            self._station.turn(Command(self._rules.clear, self._heights.passing, False, picture=False))


def _at(fruit: Fruit) -> tuple[float, float]:
    return fruit.x, fruit.y
