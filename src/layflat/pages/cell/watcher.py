"""Observer of a run for its page: present action, results of picks, pace of the clock, and images at a limited rate."""

import time
from collections import Counter, deque
from collections.abc import Callable, Sequence
from io import BytesIO
from math import hypot, nan
from typing import Any, Protocol

import numpy as np
from PIL import Image

from layflat.arrays import Array, Picture
from layflat.cell.extras import opencv
from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit, PickChoice
from layflat.cell.plan.pick import PickPhase, PickState
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Detection, draw_detections
from layflat.cell.work.evaluation import Evaluator
from layflat.cell.work.observer import Delivery, Observer, Pick, Verdict
from layflat.cell.work.results import count_reasons, describe_trouble, pick_row, sort_name
from layflat.pages.cell.snapshot import MAX_PICK_ROWS, PickFigures, RunRequests, RunStage, format_counts

JPEG_QUALITY = 75  # of JPEG: 30 to 90 kB an image
SAME_FRUIT_DISTANCE = 15e-3  # between two detections of one fruit, at most, m
MARK_MARGIN = 9.0  # from the outline of a fruit to its mark, px
MARK_OUTLINE_COLOUR, MARK_COLOUR = (0, 0, 0), (255, 255, 255)
MIN_FRAME_TIME, MIN_FAST_FRAME_TIME = (
    0.125,
    0.2,
)  # of real time between two overviews, in real time and as fast as it computes, s
UNMARKED_IMAGE_TIME, MARKED_IMAGE_TIME = (0.4, 1.0)  # time that an image of the camera is shown before the next one, s
MAX_CATCH_UP = 0.5  # lag of the cell behind real time that is still made up for: more than an image takes, s
PACE_WINDOW = 4.0  # over which the pace is averaged, s


def encode_jpeg(picture: Picture) -> bytes:
    """Return a picture, (H, W, 3) RGB, as a JPEG file."""
    file = BytesIO()
    Image.fromarray(picture).save(file, "JPEG", quality=JPEG_QUALITY)
    return file.getvalue()


def draw_observation(observation: Observation, chosen: Fruit | None) -> Picture:
    """Return a copy of an observation's picture (it must have one) with detections, and a ring around the chosen."""
    assert observation.picture is not None
    picture = draw_detections(observation.picture, observation.detections)
    detection = None if chosen is None else detection_of(observation, chosen)
    if detection is not None:
        _draw_mark(picture, detection.outline)
    return picture


def detection_of(observation: Observation, fruit: Fruit) -> Detection | None:
    """Return the detection nearest to a fruit in x and y; None where none is nearer than `SAME_FRUIT_DISTANCE`."""

    def distance(detection: Detection) -> float:
        return hypot(detection.position[0] - fruit.x, detection.position[1] - fruit.y)

    nearest = min(observation.detections, key=distance, default=None)
    return nearest if nearest is not None and distance(nearest) < SAME_FRUIT_DISTANCE else None


def _draw_mark(picture: Picture, outline: Array) -> None:
    """Draw a ring around an outline, (N, 2) px, on a picture in place, and "chosen" above it, or below without room."""
    cv2 = opencv()
    (x, y), radius = outline.mean(axis=0), float(np.linalg.norm(outline - outline.mean(axis=0), axis=1).max())
    for colour, thickness in ((MARK_OUTLINE_COLOUR, 8), (MARK_COLOUR, 4)):
        cv2.circle(picture, (round(x), round(y)), round(radius + MARK_MARGIN), colour, thickness, cv2.LINE_AA)
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.7
    (text_width, text_height), _ = cv2.getTextSize("chosen", font, size, 2)
    above = y - radius - 2 * MARK_MARGIN
    base = above if above > text_height else y + radius + 2 * MARK_MARGIN + text_height
    for colour, thickness in ((MARK_OUTLINE_COLOUR, 5), (MARK_COLOUR, 2)):
        cv2.putText(
            picture, "chosen", (round(x - text_width / 2), round(base)), font, size, colour, thickness, cv2.LINE_AA
        )


class RunDisplay(Protocol):
    """Display of a run: receives fields of its snapshot, and images."""

    requests: RunRequests

    def show(self, **changes: Any) -> None:
        """Change fields of the snapshot."""

    def image(self, name: str, jpeg: bytes) -> None:
        """Replace the image "overview" or "camera"."""


class RunImages:
    """Images of a run for its page: overviews of the cell, and its camera's; `now` is a clock of real time, s."""

    def __init__(self, display: RunDisplay, now: Callable[[], float]) -> None:
        """Begin without a camera or an image."""
        self._display, self._now = display, now
        self._camera: SimulatedCamera | None = None
        self._frame_at = self._image_at = 0.0  # when the next overview and camera image are due, s
        self._last: Observation | None = None
        self._is_pending = False  # whether the last image has not been shown yet
        self._chosen: Fruit | None = None

    def begin_delivery(self, camera: SimulatedCamera | None) -> None:
        """Begin a delivery; `camera` is None where no image can be rendered."""
        self._camera, self._chosen = camera, None

    def end_delivery(self) -> None:
        """End a delivery: show its last images."""
        self._image_at = 0.0
        self.show()
        self._camera = self._last = None

    @property
    def is_due(self) -> bool:
        """True if it is time for an overview."""
        return self._now() >= self._frame_at

    def show(self) -> None:
        """Show an overview, due or not, and the camera's pending image if the previous one was shown long enough."""
        self._frame_at = self._now() + (MIN_FAST_FRAME_TIME if self._display.requests.full_speed else MIN_FRAME_TIME)
        if self._camera is not None:
            self._display.image("overview", encode_jpeg(self._camera.picture("overview")))
        if self._is_pending and self._now() >= self._image_at:
            self._show_image()

    def observe(self, observation: Observation) -> None:
        """Show an image of the camera, now or once the previous one was shown long enough."""
        self._last, self._is_pending, self._chosen = observation, True, None
        if self._now() >= self._image_at:
            self._show_image()

    def choose(self, fruit: Fruit, observation: Observation) -> None:
        """Show the image by which a fruit was chosen at once, with a ring around the fruit."""
        self._last, self._chosen = observation, fruit
        self._show_image()

    def _show_image(self) -> None:
        """Show the last observation, if any: its image with marks and counts of fruit; set when the next is due.

        An observation without a picture has counts alone.
        """
        observation, self._is_pending = self._last, False
        if observation is None:
            return
        self._image_at = self._now() + (UNMARKED_IMAGE_TIME if self._chosen is None else MARKED_IMAGE_TIME)
        if observation.picture is not None:
            self._display.image("camera", encode_jpeg(draw_observation(observation, self._chosen)))
        self._display.show(fruit_counts=format_counts(fruit.kind for fruit in observation.fruits))


class Pace:
    """Pace of the cell's clock against real time; `now` (s) and `sleep` are those of a clock that tests may replace."""

    def __init__(self, now: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep) -> None:
        """Begin a delivery now: the cell's time is 0."""
        self.now, self._sleep = now, sleep
        self._offset = 0.0  # real time less cell time, s
        self._marks: deque[tuple[float, float]] = deque()
        self.begin_delivery()

    def begin_delivery(self) -> None:
        """Restart the cell's clock: a delivery begins."""
        self._offset = self.now()
        self._marks.clear()

    def hold(self, cell: float, *, fast: bool) -> None:
        """Wait until real time has reached the cell's time (s since the delivery began).

        With `fast`, or if the cell is late by more than `MAX_CATCH_UP`, do not wait, and count from now on.
        """
        ahead = cell + self._offset - self.now()
        if fast or ahead < -MAX_CATCH_UP:
            self._offset -= ahead
        elif ahead > 0.0:
            self._sleep(ahead)

    def ratio(self, cell: float) -> float:
        """Return cell time over real time since the oldest call within `PACE_WINDOW`; NaN at the first call.

        `cell` is the cell's time, s since the delivery began.
        """
        now = self.now()
        self._marks.append((now, cell))
        while now - self._marks[0][0] > PACE_WINDOW:
            self._marks.popleft()
        first_real, first_cell = self._marks[0]
        return (cell - first_cell) / (now - first_real) if now > first_real else nan


CHOOSING_TEXT = "The cell chooses the next fruit, and the arm moves towards it."


class Watcher(Observer):
    """Observer that shows a run on its page. It only draws and reads: the run is the same as without it."""

    def __init__(self, display: RunDisplay, pace: Pace | None = None) -> None:
        """Begin before the first delivery; `pace` is that of real clocks by default."""
        self._display, self._pace = display, pace or Pace()
        self._frames = RunImages(display, self._pace.now)
        self._before = PickFigures()  # figures of the deliveries before this one
        self._deliveries = 0
        self._rows: list[tuple[str, ...]] = []  # of picks in them, as are troubles and reasons
        self._troubles: list[str] = []
        self._reasons: list[str] = []
        self._picks: list[Pick] = []  # in this delivery

    def on_delivery_start(self, scene: Scene, camera: SimulatedCamera | None) -> None:
        """Start a new delivery: reset evaluator and pace, show its number, and the cell before any motion."""
        self._scene, self._evaluator = scene, Evaluator(scene)
        self._pace.begin_delivery()
        self._frames.begin_delivery(camera)
        self._display.show(stage=RunStage.PACKS, images=camera is not None, delivery=self._deliveries + 1)
        self._display.show(fruit="", doing="The cell takes an image.")
        self._frame(0.0)

    def on_control_cycle(self, time: float) -> None:
        """Hold the run back to real time unless full speed is requested, and show a frame if one is due.

        Raises:
            KeyboardInterrupt: the end of the run is requested.
        """
        requests = self._display.requests
        if requests.stop:
            raise KeyboardInterrupt
        self._pace.hold(time, fast=requests.full_speed)
        if self._frames.is_due:
            self._frame(time)

    def on_pick_start(self, fruit: Fruit, observation: Observation) -> None:
        """Show the image by which a fruit was chosen, with a ring around it."""
        self._frames.choose(fruit, observation)

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:
        """Show the fruit that is being picked, and the phase that the arm is in, unless the pick is done.

        Args:
            choice: fruit and its target place.
            before: state of the pick before the transition.
            after: state after it.
        """
        self._evaluator.on_phase_change(choice, before, after)
        if after.phase is PickPhase.DONE:
            return
        fruit, place = choice.fruit, choice.place
        what = f"{sort_name(fruit)}, {1e3 * fruit.diameter:.0f} mm, to place {place.name} of {place.container}"
        self._display.show(fruit=what, doing=f"The arm {after.phase.value}.")

    def on_image(self, observation: Observation) -> None:
        """Show an image of the camera, once the previous one was shown long enough."""
        self._evaluator.on_image(observation)
        self._frames.observe(observation)

    def on_pick_end(self, pick: Pick) -> None:
        """Show the result of a pick, as far as it is known before its delivery is over."""
        self._evaluator.on_pick_end(pick)
        self._picks.append(pick)
        picks, verdicts = self._picks, self._evaluator.verdicts(self._picks)
        collisions, false = len(self._scene.truth().collisions), self._evaluator.vision.false
        self._show_picks(picks, verdicts, _pick_figures(picks, verdicts, pick.end, collisions, false))
        self._display.show(fruit="", doing=CHOOSING_TEXT)

    def on_delivery_end(self, delivery: Delivery) -> None:
        """Show the evaluation of a delivery, and add its figures and rows to those of earlier ones."""
        self._frames.end_delivery()
        self._frame(delivery.time)
        picks, verdicts = delivery.picks, delivery.verdicts
        self._reasons += [one.reason for one in delivery.not_picked]
        figures = _pick_figures(picks, verdicts, delivery.time, len(delivery.collisions), delivery.vision.false)
        rows, troubles = self._show_picks(picks, verdicts, figures)
        self._before, self._rows, self._troubles = (
            self._before + figures,
            rows[-MAX_PICK_ROWS:],
            troubles[-MAX_PICK_ROWS:],
        )
        self._deliveries, self._picks = self._deliveries + 1, []
        self._display.show(fruit="", doing="The arm stands still." if delivery.error else "The tray is changed.")

    def _show_picks(
        self, picks: Sequence[Pick], verdicts: Sequence[Verdict], figures: PickFigures
    ) -> tuple[list[tuple[str, ...]], list[str]]:
        """Show the figures, summed with those of earlier deliveries, and the last picks; return rows and troubles.

        Those are of all picks of this delivery, after the last `MAX_PICK_ROWS` of earlier ones.
        """
        named = [(f"{self._deliveries + 1}.{pick.number}", pick) for pick in picks]
        rows = self._rows + [pick_row(name, pick, one) for (name, pick), one in zip(named, verdicts, strict=True)]
        troubles = self._troubles + [text for name, pick in named if (text := describe_trouble(name, pick))]
        remarks = (*troubles[-MAX_PICK_ROWS:], *count_reasons(self._reasons))
        self._display.show(figures=self._before + figures, rows=tuple(rows[: -MAX_PICK_ROWS - 1 : -1]), remarks=remarks)
        return rows, troubles

    def _frame(self, time: float) -> None:
        """Show images, time and pace at a time of this delivery, s."""
        self._frames.show()
        self._display.show(time=self._before.time + time, pace=self._pace.ratio(time))


def _pick_figures(
    picks: Sequence[Pick], verdicts: Sequence[Verdict], time: float, collisions: int, false_detections: int
) -> PickFigures:
    """Return the figures of the picks so far: verdicts counted by word, air (normal litres), time (s) and errors."""
    words = Counter(verdict.word(pick) for pick, verdict in zip(picks, verdicts, strict=True))
    return PickFigures(words, sum(pick.air for pick in picks), time, collisions, false_detections)
