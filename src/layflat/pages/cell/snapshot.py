"""What travels from a run to the process that shows it, and back: plain values, without images."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from math import nan
from multiprocessing.sharedctypes import RawArray

STOP, FAST = range(2)
ROWS = 10  # picks that are shown one by one


@dataclass(frozen=True)
class About:
    """What a run is of, and how much it is asked for."""

    cell: str
    machine: str
    seed: int
    picks: int
    columns: tuple[str, ...]  # heads of the rows of picks


class Stage(Enum):
    """How far a run is."""

    CALIBRATES = "Calibrating the camera"
    PACKS = "The cell packs"
    ENDED = "The run has ended"


@dataclass(frozen=True)
class Figures:
    """What came of picks; figures of several deliveries can be added."""

    results: Counter[str] = field(default_factory=Counter)  # number of picks by what came of each, in a word
    air: float = 0.0  # of all picks, normal litres
    time: float = 0.0  # of the cell, in which they were made, s
    collisions: int = 0
    false_detections: int = 0

    @property
    def picks(self) -> int:
        """How many there are."""
        return self.results.total()

    @property
    def picks_a_minute(self) -> float:
        """In the time of the cell; not a number without any."""
        return 60.0 * self.picks / self.time if self.time else nan

    @property
    def air_each(self) -> float:
        """Of a pick in the mean, normal litres; not a number without picks."""
        return self.air / self.picks if self.picks else nan

    def __add__(self, other: "Figures") -> "Figures":
        """Return figures of the picks of both."""
        return Figures(
            self.results + other.results, self.air + other.air, self.time + other.time,
            self.collisions + other.collisions, self.false_detections + other.false_detections,
        )  # fmt: skip


@dataclass(frozen=True)
class Snapshot:
    """A run at an instant."""

    stage: Stage = Stage.CALIBRATES
    calibrated: float = 0.0  # share
    images: bool = True  # whether any can be rendered
    delivery: int = 1  # that is worked off, from 1
    time: float = 0.0  # of the cell in all deliveries, s
    pace: float = nan  # by which its time goes faster than real time
    fruit: str = ""  # that is being picked, and where it goes; empty between picks
    doing: str = ""  # what the arm does, as a sentence
    seen: str = ""  # what the last image of the camera shows
    figures: Figures = field(default_factory=Figures)
    rows: tuple[tuple[str, ...], ...] = ()  # of the last picks, the newest first
    remarks: tuple[str, ...] = ()  # what went wrong in them, and why other fruit was not picked
    summary: tuple[str, ...] = ()  # once it has ended
    written: tuple[str, ...] = ()  # files, likewise
    error: str = ""  # what ended it early


class Requests:
    """What people ask of a run on its pages, in memory that both processes share."""

    def __init__(self) -> None:
        self._flags = RawArray("b", 2)

    @property
    def stop(self) -> bool:
        """Whether it is to end."""
        return bool(self._flags[STOP])

    @stop.setter
    def stop(self, yes: bool) -> None:
        self._flags[STOP] = yes

    @property
    def fast(self) -> bool:
        """Whether it is to go as fast as it computes, not in real time."""
        return bool(self._flags[FAST])

    @fast.setter
    def fast(self, yes: bool) -> None:
        self._flags[FAST] = yes


def listed(things: Iterable[str]) -> str:
    """Return how many there are of each thing, such as "apple 2, tomato 5"; "nothing" where there is none."""
    return ", ".join(f"{thing} {count}" for thing, count in sorted(Counter(things).items())) or "nothing"
