"""Observer of a run for its page: what is done, what came of picks, images; and the pace of the clock."""

import time
from collections import Counter, deque
from collections.abc import Callable, Sequence
from math import nan

from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Phase, State
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.work.evaluation import Evaluator
from layflat.cell.work.observer import Observer
from layflat.cell.work.records import Delivery, Pick, Verdict
from layflat.cell.work.tables import not_picked, row, sort, trouble
from layflat.pages.cell.frames import Frames, Shows
from layflat.pages.cell.snapshot import ROWS, Figures, Stage

LAG = 0.5  # by which the cell may be behind and still catch up: more than an image takes, s
SPAN = 4.0  # over which the pace is measured, s


class Pace:
    """Compares the cell's clock with real time; `now` (s) and `sleep` are those of a clock that tests may replace."""

    def __init__(self, now: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep) -> None:
        self.now, self._sleep = now, sleep
        self._ahead_of = 0.0  # real time less the cell's, where both agree, s
        self._marks: deque[tuple[float, float]] = deque()
        self.begin()

    def begin(self) -> None:
        """Restart the cell's clock: a delivery begins."""
        self._ahead_of = self.now()
        self._marks.clear()

    def hold(self, cell: float, *, fast: bool) -> None:
        """Wait until real time is as far as the cell's (s since it began), unless it is to go fast."""
        ahead = cell + self._ahead_of - self.now()
        if fast or ahead < -LAG:
            self._ahead_of -= ahead
        elif ahead > 0.0:
            self._sleep(ahead)

    def measured(self, cell: float) -> float:
        """Return by which the cell's time went faster than real time lately; not a number at first."""
        now = self.now()
        self._marks.append((now, cell))
        while now - self._marks[0][0] > SPAN:
            self._marks.popleft()
        since, then = self._marks[0]
        return (cell - then) / (now - since) if now > since else nan


CHOOSES = "The cell chooses the next fruit, and the arm moves towards it."


class Watcher(Observer):
    """Shows a run as it goes. It draws and reads, so that the run is the same as without it."""

    def __init__(self, shows: Shows, pace: Pace | None = None) -> None:
        self._shows, self._pace = shows, pace or Pace()
        self._frames = Frames(shows, self._pace.now)
        self._over = Figures()  # of the deliveries before this one
        self._deliveries = 0
        self._rows: list[tuple[str, ...]] = []  # of picks in them, likewise what follows
        self._troubles: list[str] = []
        self._reasons: list[str] = []
        self._picks: list[Pick] = []  # in this delivery

    def begins(self, scene: Scene, camera: SimulatedCamera | None) -> None:
        """Show the cell before anything moves."""
        self._scene, self._evaluator = scene, Evaluator(scene)
        self._pace.begin()
        self._frames.begin(camera)
        self._shows.show(stage=Stage.PACKS, images=camera is not None, delivery=self._deliveries + 1)
        self._shows.show(fruit="", doing="The cell takes an image.")
        self._frame(0.0)

    def cycle(self, time: float) -> None:
        """Show a frame, if it is time for one; end or hold back the run, if that is asked for."""
        asked = self._shows.asked
        if asked.stop:
            raise KeyboardInterrupt
        self._pace.hold(time, fast=asked.fast)
        if self._frames.due:
            self._frame(time)

    def chosen(self, fruit: Fruit, observation: Observation) -> None:
        """Show the image by which a fruit was chosen, with a ring around it."""
        self._frames.choose(fruit, observation)

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """Show what is being picked, and what the arm does."""
        self._evaluator.phase(choice, before, after)
        if after.phase is Phase.DONE:
            return
        fruit, place = choice.fruit, choice.place
        what = f"{sort(fruit)}, {1e3 * fruit.diameter:.0f} mm, to place {place.name} of {place.container}"
        self._shows.show(fruit=what, doing=f"The arm {after.phase.value}.")

    def observed(self, observation: Observation) -> None:
        """Show an image of the camera, once the one before has been seen."""
        self._evaluator.observed(observation)
        self._frames.observe(observation)

    def picked(self, pick: Pick) -> None:
        """Show what came of a pick, as far as it can be said before its delivery is over."""
        self._evaluator.picked(pick)
        self._picks.append(pick)
        picks, verdicts = self._picks, self._evaluator.verdicts(self._picks)
        collisions, false = len(self._scene.truth().collisions), self._evaluator.vision.false
        self._tell(picks, verdicts, _figures(picks, verdicts, pick.end, collisions, false))
        self._shows.show(fruit="", doing=CHOOSES)

    def ends(self, delivery: Delivery) -> None:
        """Show what the evaluation of a delivery says."""
        self._frames.end()
        self._frame(delivery.time)
        picks, verdicts = delivery.picks, delivery.verdicts
        self._reasons += [one.reason for one in delivery.not_picked]
        figures = _figures(picks, verdicts, delivery.time, len(delivery.collisions), delivery.vision.false)
        rows, troubles = self._tell(picks, verdicts, figures)
        self._over, self._rows, self._troubles = self._over + figures, rows[-ROWS:], troubles[-ROWS:]
        self._deliveries, self._picks = self._deliveries + 1, []
        self._shows.show(fruit="", doing="The arm stands still." if delivery.error else "The tray is changed.")

    def _tell(
        self, picks: Sequence[Pick], verdicts: Sequence[Verdict], figures: Figures
    ) -> tuple[list[tuple[str, ...]], list[str]]:
        """Show figures and the last picks; return rows and troubles of all that are known."""
        named = [(f"{self._deliveries + 1}.{pick.number}", pick) for pick in picks]
        rows = self._rows + [row(name, pick, one) for (name, pick), one in zip(named, verdicts, strict=True)]
        troubles = self._troubles + [text for name, pick in named if (text := trouble(name, pick))]
        remarks = (*troubles[-ROWS:], *not_picked(self._reasons))
        self._shows.show(figures=self._over + figures, rows=tuple(rows[: -ROWS - 1 : -1]), remarks=remarks)
        return rows, troubles

    def _frame(self, time: float) -> None:
        """Show the cell as it is at a time of this delivery, s."""
        self._frames.show()
        self._shows.show(time=self._over.time + time, pace=self._pace.measured(time))


def _figures(
    picks: Sequence[Pick], verdicts: Sequence[Verdict], time: float, collisions: int, false_detections: int
) -> Figures:
    words = Counter(verdict.word(pick) for pick, verdict in zip(picks, verdicts, strict=True))
    return Figures(words, sum(pick.air for pick in picks), time, collisions, false_detections)
