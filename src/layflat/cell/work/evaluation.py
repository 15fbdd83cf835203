"""Evaluation of a cell's work by the truth of its scene, which the cell itself does not know."""

from collections.abc import Iterable
from math import dist, hypot, nan

from layflat.cell.perception import Observation
from layflat.cell.plan.order import Packing, PickChoice
from layflat.cell.plan.pick import PickOutcome, PickPhase, PickState
from layflat.cell.scene import Scene
from layflat.cell.scene.truth import FruitTruth
from layflat.cell.vision.detection import SURE_CONFIDENCE
from layflat.cell.work.observer import Observer, Pick, Verdict, VisionErrors

MATCHING_DISTANCE = 20e-3  # of a detection to the fruit that it is matched with, upper limit, m


class Evaluator(Observer):
    """Observer that evaluates a packer by its scene; `vision` has the errors of its detections."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self.vision = scene, VisionErrors()
        self._carried, self._error = "", nan
        self._picks: list[tuple[str, float]] = []

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:
        """Record the carried fruit, and on its release its distance from the middle of its place.

        Args:
            choice: fruit and place of the pick.
            before: state of the pick in its last phase.
            after: state in its new phase.
        """
        fruits = self._scene.truth().fruits
        if after.phase is PickPhase.CARRY and before.phase is PickPhase.LIFT:
            held = [fruit.name for fruit in fruits.values() if fruit.gripped]
            self._carried = held[0] if held else ""
        if after.phase is PickPhase.RELEASE and self._carried:
            place = choice.place
            self._error = dist(fruits[self._carried].position[:2].tolist(), (place.x, place.y))

    def on_image(self, observation: Observation) -> None:
        """Add the errors of sure detections of known kinds to `vision`, without those in containers.

        A detection counts as false if no fruit of its kind is within `MATCHING_DISTANCE`.
        """
        fruits = [fruit for fruit in self._scene.truth().fruits.values() if not fruit.gripped]
        for detected in observation.fruits:
            if detected.confidence < SURE_CONFIDENCE or detected.kind not in self._scene.cell.produce:
                continue
            distances = {
                fruit.name: hypot(detected.x - fruit.position[0], detected.y - fruit.position[1]) for fruit in fruits
            }
            matches = [
                fruit for fruit in fruits if fruit.kind == detected.kind and distances[fruit.name] < MATCHING_DISTANCE
            ]
            if not matches:
                self.vision.false += 1
                continue
            matched = min(matches, key=lambda fruit: distances[fruit.name])
            if matched.place is None:
                self.vision.positions.append(float(distances[matched.name]))
                self.vision.diameters.append(abs(detected.diameter / matched.diameter - 1.0))

    def overlooked(self, packing: Packing) -> int:
        """Return the number of fruit outside containers whose kind and grade, if not size, a free place accepts."""
        cell, open_containers = self._scene.cell, {place.container for place in packing.free}
        accepted = {(cell.container[name].kind, cell.container[name].grade) for name in open_containers}
        fruits = self._scene.truth().fruits.values()
        return sum(fruit.place is None and (fruit.kind, fruit.grade) in accepted for fruit in fruits)

    def on_pick_end(self, pick: Pick) -> None:  # noqa: ARG002  (as all observers)
        """Append the fruit carried in this pick and its distance from its place at release (m), and reset both."""
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
        """Return the verdict on a pick: correct if placed, in the chosen place, among its kind and grade."""
        place = pick.choice.place
        container = self._scene.cell.container[place.container]
        inside = fruit.place is not None and fruit.place[0] == place.container
        x, y = container.places[fruit.place[1]] if inside and fruit.place is not None else (nan, nan)
        in_chosen_place = dist((x, y), (place.x, place.y)) < 1e-6
        belongs = (fruit.kind, fruit.grade) == (container.kind, container.grade)
        correct = pick.outcome is PickOutcome.PLACED and in_chosen_place and belongs
        return Verdict(fruit.name, fruit.kind, fruit.grade, correct, error, fruit.peak_acceleration, fruit.press)
