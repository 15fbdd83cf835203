"""What is kept of a cell's work: picks, what is true of them, deliveries."""

from dataclasses import dataclass, field, replace
from math import nan
from typing import Self

from layflat.cell.perception import Observation
from layflat.cell.plan.order import Choice, NotPicked
from layflat.cell.plan.pick import Outcome
from layflat.cell.scene.truth import Collision
from layflat.errors import LayflatError


@dataclass(frozen=True)
class Pick:
    """One pick, as the cell itself knows it."""

    number: int  # from 1
    choice: Choice  # what was to be picked, and where it was to go
    outcome: Outcome
    trouble: str  # what went wrong last, as one clause; empty where nothing did
    tries: int  # how often the cup went down for it
    begin: float  # s
    end: float  # s
    air: float  # normal litres
    observation: Observation  # the last one in which it was seen before


@dataclass(frozen=True)
class Verdict:
    """What is true of a pick once its delivery is over."""

    fruit: str = ""  # name of what was carried; empty where nothing was
    kind: str = ""
    grade: str | None = None  # None where it is of none
    correct: bool = False  # whether it lies in the chosen place, and is of the kind and grade that belong there
    release_error: float = nan  # from its middle to that of its place when it was released, m; nan if it never was
    peak_acceleration: float = nan  # greatest since the scene began, m/s^2
    press: float = nan  # greatest force of the cup on it, N

    def word(self, pick: Pick) -> str:
        """Return what came of the pick in a word."""
        if self.correct:
            return "correct"
        return "wrong" if pick.outcome is Outcome.PLACED else pick.outcome.name.lower()


@dataclass
class VisionErrors:
    """What was detected surely in the trays, against what lay there, over all images of a delivery."""

    positions: list[float] = field(default_factory=list)  # errors on the table, m
    diameters: list[float] = field(default_factory=list)  # errors, share
    false: int = 0  # detections of a known kind where no fruit of that kind is


@dataclass(frozen=True, eq=False)
class Delivery:
    """What came of a delivery."""

    seed: int  # of its scene
    picks: tuple[Pick, ...]
    verdicts: tuple[Verdict, ...]  # of each pick
    not_picked: tuple[NotPicked, ...]  # and why
    collisions: tuple[Collision, ...]  # of arm, lift or cup with what they should not touch
    time: float  # from the first image to the last, s
    vision: VisionErrors  # in what lay in the trays
    overlooked: int | None = None  # fruit that could have been packed in trays that were worked off; else None
    error: LayflatError | None = None  # what ended it early

    @property
    def without_pictures(self) -> Self:
        """The same but for its pictures, of which a hundred picks have half a GB."""
        bare = (replace(pick.observation, picture=None, detections=()) for pick in self.picks)
        picks = (replace(pick, observation=observation) for pick, observation in zip(self.picks, bare, strict=True))
        return replace(self, picks=tuple(picks))
