"""Evaluates what a cell does by what is true in the scene, which the cell itself never learns."""

from collections.abc import Iterable
from math import dist, hypot, nan

from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Packing
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Outcome, Phase, State
from layflat.cell.scene import Scene
from layflat.cell.scene.truth import FruitTruth
from layflat.cell.vision.detection import SURE
from layflat.cell.work.observer import Observer
from layflat.cell.work.records import Pick, Verdict, VisionErrors

NEAR = 20e-3  # how far a fruit may be from where it was seen to be meant by it, m


class Evaluator(Observer):
    """Observes a packer in its scene; `vision` holds the errors of what it detects."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self.vision = scene, VisionErrors()
        self._carried, self._error = "", nan
        self._picks: list[tuple[str, float]] = []

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """Note what is carried, and where it is released."""
        fruits = self._scene.truth().fruits
        if after.phase is Phase.CARRY and before.phase is Phase.LIFT:
            held = [fruit.name for fruit in fruits.values() if fruit.held]
            self._carried = held[0] if held else ""
        if after.phase is Phase.RELEASE and self._carried:
            place = choice.place
            self._error = dist(fruits[self._carried].position[:2].tolist(), (place.x, place.y))

    def observed(self, observation: Observation) -> None:
        """Compare what was detected with what is there."""
        fruits = [fruit for fruit in self._scene.truth().fruits.values() if not fruit.held]
        for seen in observation.fruits:
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
        """Count fruit that lies in no container though a place that is free takes its kind and grade."""
        cell, free = self._scene.cell, {place.container for place in packing.free}
        taken = {(cell.container[name].kind, cell.container[name].grade) for name in free}
        fruits = self._scene.truth().fruits.values()
        return sum(fruit.place is None and (fruit.kind, fruit.grade) in taken for fruit in fruits)

    def picked(self, pick: Pick) -> None:  # noqa: ARG002  (as all observers)
        """Keep what was noted of the pick."""
        self._picks.append((self._carried, self._error))
        self._carried, self._error = "", nan

    def verdicts(self, picks: Iterable[Pick]) -> list[Verdict]:
        """Return the verdicts of all picks, now that the delivery is over."""
        truth = self._scene.truth().fruits
        return [
            self._verdict(pick, truth[name], error) if name else Verdict()
            for pick, (name, error) in zip(picks, self._picks, strict=True)
        ]

    def _verdict(self, pick: Pick, fruit: FruitTruth, error: float) -> Verdict:
        place = pick.choice.place
        container = self._scene.cell.container[place.container]
        inside = fruit.place is not None and fruit.place[0] == place.container
        x, y = container.places[fruit.place[1]] if inside and fruit.place is not None else (nan, nan)
        there = dist((x, y), (place.x, place.y)) < 1e-6
        belongs = (fruit.kind, fruit.grade) == (container.kind, container.grade)
        correct = pick.outcome is Outcome.PLACED and there and belongs
        return Verdict(fruit.name, fruit.kind, fruit.grade, correct, error, fruit.peak_acceleration, fruit.press)
