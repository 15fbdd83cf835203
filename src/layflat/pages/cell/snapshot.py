"""Messages from a run to the process that shows it, and back: plain values, without images."""

from collections import Counter
from collections.abc import Iterable
from ctypes import Structure, c_bool
from dataclasses import dataclass, field
from enum import Enum
from math import nan
from multiprocessing.sharedctypes import RawValue
from typing import Self

MAX_PICK_ROWS = 10  # picks shown one by one in the table


@dataclass(frozen=True)
class RunSubject:
    """Subject of a run, and the amount that is demanded of it."""

    cell: str
    machine: str
    seed: int
    picks: int
    columns: tuple[str, ...]  # heads of the rows of picks


class RunStage(Enum):
    """Stage of a run."""

    CALIBRATES = "Calibrating the camera"
    PACKS = "The cell packs"
    ENDED = "The run has ended"


@dataclass(frozen=True)
class PickFigures:
    """Figures of picks; those of several deliveries can be added."""

    results: Counter[str] = field(default_factory=Counter)  # number of picks by result, in a word
    air: float = 0.0  # of all picks, normal litres
    time: float = 0.0  # of the cell, in which they were made, s
    collisions: int = 0
    false_detections: int = 0

    @property
    def picks(self) -> int:
        """Number of picks."""
        return self.results.total()

    @property
    def picks_a_minute(self) -> float:
        """Picks a minute of the cell's time; NaN while no time has passed."""
        return 60.0 * self.picks / self.time if self.time else nan

    @property
    def air_each(self) -> float:
        """Mean air of a pick, normal litres; NaN without picks."""
        return self.air / self.picks if self.picks else nan

    def __add__(self, other: "PickFigures") -> "PickFigures":
        """Return the figures of both sets of picks together."""
        return PickFigures(
            self.results + other.results, self.air + other.air, self.time + other.time,
            self.collisions + other.collisions, self.false_detections + other.false_detections,
        )  # fmt: skip


@dataclass(frozen=True)
class RunSnapshot:
    """State of a run at an instant, as its page shows it."""

    stage: RunStage = RunStage.CALIBRATES
    calibrated: float = 0.0  # fraction of the calibration done, 0..1
    images: bool = True  # whether images can be rendered
    delivery: int = 1  # number of the present delivery, from 1
    time: float = 0.0  # of the cell in all deliveries, s
    pace: float = nan  # cell time over real time
    fruit: str = ""  # fruit that is being picked, and its target place; empty between picks
    doing: str = ""  # present action of the arm, as a sentence
    fruit_counts: str = ""  # counts of fruit in the last image of the camera
    figures: PickFigures = field(default_factory=PickFigures)
    rows: tuple[tuple[str, ...], ...] = ()  # of the last picks, the newest first
    remarks: tuple[str, ...] = ()  # problems in them, and reasons for which other fruit was not picked
    summary: tuple[str, ...] = ()  # lines about the results, once the run has ended
    written: tuple[str, ...] = ()  # paths of the files written, once the run has ended
    error: str = ""  # message of the error that ended the run early


class RunRequests(Structure):
    """Requests of a page to its run: `stop` ends it, `full_speed` lets it run as fast as it computes."""

    stop: bool
    full_speed: bool
    _fields_ = [("stop", c_bool), ("full_speed", c_bool)]

    @classmethod
    def shared(cls) -> Self:
        """Return requests, none of them made, in memory that processes share without a lock."""
        requests: Self = RawValue(cls)
        return requests


def format_counts(things: Iterable[str]) -> str:
    """Return the count of each text, in alphabetical order, such as "apple 2, tomato 5"; "nothing" without texts."""
    return ", ".join(f"{thing} {count}" for thing, count in sorted(Counter(things).items())) or "nothing"
