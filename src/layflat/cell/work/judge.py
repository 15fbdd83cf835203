"""Judges what a cell does by what is true in the scene, which the cell itself never learns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import dist, hypot, nan

from layflat.cell.file.checks import places
from layflat.cell.plan.order import Choice
from layflat.cell.plan.packs import Packing
from layflat.cell.plan.pick import Outcome, Phase, State
from layflat.cell.scene import Scene
from layflat.cell.scene.truth import Collision, FruitTruth
from layflat.cell.vision.detection import SURE
from layflat.cell.work.eyes import Sight
from layflat.cell.work.packer import Pick

NEAR = 20e-3
"""How far a fruit may be from where it was seen to be meant by it, m."""


@dataclass(frozen=True)
class Verdict:
    """What is true of a pick once its delivery is over.

    Attributes:
        fruit: name of what was carried; empty where nothing was.
        kind, grade: of it; the grade is None where it is of none.
        right: whether it lies in the place that was chosen, and is of the kind and grade that belong there.
        release_error: from its middle to that of its place when it was let go, m; not a number where it never was.
        peak_acceleration: greatest since the scene began, m/s^2.
        press: greatest force of the cup on it, N.
    """

    fruit: str = ""
    kind: str = ""
    grade: str | None = None
    right: bool = False
    release_error: float = nan
    peak_acceleration: float = nan
    press: float = nan

    def told(self, pick: Pick) -> str:
        """What came of the pick in a word."""
        if self.right:
            return "right"
        return "wrong" if pick.outcome is Outcome.PLACED else pick.outcome.name.lower()


@dataclass
class Vision:
    """What was seen surely in the trays, against what lay there, over all pictures of a delivery.

    Attributes:
        positions: errors on the table, m.
        diameters: errors, share.
        false: finds of a known kind where no fruit of that kind is.
    """

    positions: list[float] = field(default_factory=list)
    diameters: list[float] = field(default_factory=list)
    false: int = 0


class Judge:
    """Watches a packer.

    Args:
        scene: in which it works.

    Attributes:
        vision: how well was seen.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene, self.vision = scene, Vision()
        self._carried, self._error = "", nan
        self._picks: list[tuple[str, float]] = []

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """Of arm, lift or cup with what they should not touch."""
        return self._scene.truth().collisions

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""
        fruits = self._scene.truth().fruits
        if after.phase is Phase.CARRY and before.phase is Phase.LIFT:
            held = [fruit.name for fruit in fruits.values() if fruit.held]
            self._carried = held[0] if held else ""
        if after.phase is Phase.RELEASE and self._carried:
            place = choice.spot.place
            self._error = dist(fruits[self._carried].position[:2].tolist(), (place.x, place.y))

    def looked(self, sight: Sight) -> None:
        """A picture was taken."""
        fruits = [fruit for fruit in self._scene.truth().fruits.values() if not fruit.held]
        for seen in sight.fruits:
            if seen.confidence < SURE or seen.kind not in self._scene.cell.produce:
                continue
            away = {fruit.name: hypot(seen.x - fruit.position[0], seen.y - fruit.position[1]) for fruit in fruits}
            same = [fruit for fruit in fruits if fruit.kind == seen.kind and away[fruit.name] < NEAR]
            if not same:
                self.vision.false += 1
                continue
            meant = min(same, key=lambda fruit: away[fruit.name])
            if meant.place is None:
                self.vision.positions.append(float(away[meant.name]))
                self.vision.diameters.append(abs(seen.diameter / meant.diameter - 1.0))

    def overlooked(self, packing: Packing) -> int:
        """Fruit that lies in no pack though a place that is free takes its kind and grade."""
        cell, free = self._scene.cell, {spot.pack for spot in packing.free}
        taken = {(cell.pack[name].kind, cell.pack[name].grade) for name in free}
        fruits = self._scene.truth().fruits.values()
        return sum(fruit.place is None and (fruit.kind, fruit.grade) in taken for fruit in fruits)

    def ended(self) -> None:
        """A pick has ended."""
        self._picks.append((self._carried, self._error))
        self._carried, self._error = "", nan

    def verdicts(self, picks: Iterable[Pick]) -> list[Verdict]:
        """Of all picks, now that the delivery is over."""
        truth = self._scene.truth().fruits
        return [
            self._verdict(pick, truth[name], error) if name else Verdict()
            for pick, (name, error) in zip(picks, self._picks, strict=True)
        ]

    def _verdict(self, pick: Pick, fruit: FruitTruth, error: float) -> Verdict:
        spot = pick.choice.spot
        pack = self._scene.cell.pack[spot.pack]
        x, y = places(pack)[fruit.place[1]] if fruit.place is not None and fruit.place[0] == spot.pack else (nan, nan)
        there = dist((x, y), (spot.place.x, spot.place.y)) < 1e-6
        belongs = (fruit.kind, fruit.grade) == (pack.kind, pack.grade)
        right = pick.outcome is Outcome.PLACED and there and belongs
        return Verdict(fruit.name, fruit.kind, fruit.grade, right, error, fruit.peak_acceleration, fruit.press)
