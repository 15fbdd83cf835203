"""Judges picks by what is true in the scene, which the cell itself never learns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import dist, nan

from layflat.cell.file.model import Cell
from layflat.cell.plan.order import Choice
from layflat.cell.plan.packs import Packing
from layflat.cell.plan.pick import Outcome, Phase, State
from layflat.cell.scene import Scene
from layflat.cell.scene.truth import Collision
from layflat.cell.work.packer import Pick


@dataclass(frozen=True)
class Verdict:
    """What is true of a pick once its delivery is over.

    Attributes:
        fruit: name of what was carried; empty where nothing was.
        kind, grade: of it; the grade is None where it is of none.
        right: whether it lies in the place that was chosen, and is of the kind and grade that belong there.
        release_error: from its middle to that of its place when it was let go, m; not a number where it never was.
        peak_acceleration: m/s^2.
        press: greatest force of the cup on it, N.
    """

    fruit: str
    kind: str
    grade: str | None
    right: bool
    release_error: float
    peak_acceleration: float
    press: float


NOTHING = Verdict("", "", None, right=False, release_error=nan, peak_acceleration=nan, press=nan)


class Judge:
    """Watches a packer's changes of phase; give `watch` to it.

    Args:
        scene: in which it works.
        packing: its packs.
    """

    def __init__(self, scene: Scene, packing: Packing) -> None:
        self._scene = scene
        self._numbers = {
            (pack.name, place.name): (pack.name, i) for pack in packing.packs for i, place in enumerate(pack.places)
        }
        self._carried, self._error = "", nan
        self._picks: list[tuple[str, float]] = []

    def watch(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""
        if after.phase is Phase.CARRY and before.phase is Phase.LIFT:
            held = [fruit.name for fruit in self._scene.truth().fruits.values() if fruit.held]
            self._carried = held[0] if held else ""
        if after.phase is Phase.RELEASE and self._carried:
            at, place = self._scene.truth().fruits[self._carried].position, choice.spot.place
            self._error = dist((float(at[0]), float(at[1])), (place.x, place.y))

    def ended(self) -> None:
        """A pick has ended."""
        self._picks.append((self._carried, self._error))
        self._carried, self._error = "", nan

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """Of arm, lift or cup with what they should not touch."""
        return self._scene.truth().collisions

    def verdicts(self, picks: Iterable[Pick], cell: Cell) -> list[Verdict]:
        """Of all picks, now that the delivery is over."""
        truth = self._scene.truth().fruits
        found = []
        for pick, (name, error) in zip(picks, self._picks, strict=True):
            if not name:
                found.append(NOTHING)
                continue
            fruit, spot = truth[name], pick.choice.spot
            pack = cell.pack[spot.pack]
            there = fruit.place == self._numbers[spot.pack, spot.place.name]
            belongs = (fruit.kind, fruit.grade) == (pack.kind, pack.grade)
            right = pick.outcome is Outcome.PLACED and there and belongs
            found.append(Verdict(name, fruit.kind, fruit.grade, right, error, fruit.peak_acceleration, fruit.press))
        return found
