"""What is kept of a cell's work: picks, what is true of them, deliveries."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import nan

from layflat.cell.perception import Observation
from layflat.cell.plan.order import Choice, NotPicked
from layflat.cell.plan.pick import Outcome
from layflat.cell.scene.truth import Collision
from layflat.errors import LayflatError


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
        observation: the last one in which it was seen before.
    """

    number: int
    choice: Choice
    outcome: Outcome
    trouble: str
    tries: int
    begin: float
    end: float
    air: float
    observation: Observation


@dataclass(frozen=True)
class Verdict:
    """What is true of a pick once its delivery is over.

    Attributes:
        fruit: name of what was carried; empty where nothing was.
        kind, grade: of it; the grade is None where it is of none.
        correct: whether it lies in the place that was chosen, and is of the kind and grade that belong there.
        release_error: placement error, from its middle to that of its place when it was released, m; not a number where
            it never was.
        peak_acceleration: greatest since the scene began, m/s^2.
        press: greatest force of the cup on it, N.
    """

    fruit: str = ""
    kind: str = ""
    grade: str | None = None
    correct: bool = False
    release_error: float = nan
    peak_acceleration: float = nan
    press: float = nan

    def word(self, pick: Pick) -> str:
        """Return what came of the pick in a word."""
        if self.correct:
            return "correct"
        return "wrong" if pick.outcome is Outcome.PLACED else pick.outcome.name.lower()


@dataclass
class VisionErrors:
    """What was detected surely in the trays, against what lay there, over all images of a delivery.

    Attributes:
        positions: errors on the table, m.
        diameters: errors, share.
        false: detections of a known kind where no fruit of that kind is.
    """

    positions: list[float] = field(default_factory=list)
    diameters: list[float] = field(default_factory=list)
    false: int = 0


@dataclass(frozen=True, eq=False)
class Delivery:
    """What came of a delivery.

    Attributes:
        seed: of its scene.
        picks: in order.
        verdicts: of each pick.
        not_picked: what was not picked, and why.
        collisions: of arm, lift or cup with what they should not touch.
        time: from the first image to the last, s.
        vision: errors in what lay in the trays.
        overlooked: fruit that could have been packed and was not, when nothing more could be picked; None where the
            delivery ended before.
        error: what ended it early; None where nothing did.
    """

    seed: int
    picks: tuple[Pick, ...]
    verdicts: tuple[Verdict, ...]
    not_picked: tuple[NotPicked, ...]
    collisions: tuple[Collision, ...]
    time: float
    vision: VisionErrors
    overlooked: int | None = None
    error: LayflatError | None = None

    @property
    def without_pictures(self) -> Delivery:
        """The same but for its pictures, of which a hundred picks have half a GB."""
        picks = [
            replace(pick, observation=replace(pick.observation, picture=None, detections=())) for pick in self.picks
        ]
        return replace(self, picks=tuple(picks))
