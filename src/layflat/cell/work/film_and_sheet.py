"""Pictures of a run: a film of the cell, and a contact sheet with the image by which each pick was chosen."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from layflat.cell.pictures import ContactSheet, Film, add_caption
from layflat.cell.plan.order import PickChoice
from layflat.cell.plan.pick import PickOutcome, PickState
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration, draw_detections
from layflat.cell.work.observer import Delivery, Observer, Pick, Verdict
from layflat.cell.work.results import PackingSummary, count_noun

FPS = 10.0  # frames of a film per second of the cell's time


class FilmAndSheet(Observer):
    """Observer that makes a film, if one is open, and a contact sheet."""

    def __init__(self, film: Film | None, sheet: ContactSheet, calibration: Calibration) -> None:
        """Store film (None: no film), sheet and calibration; pictures begin with a delivery."""
        self._film, self.sheet, self._calibration = film, sheet, calibration
        self._camera: SimulatedCamera | None = None
        self._next = 0.0
        self._doing, self._packed = "takes an image of the tray", 0
        self.deliveries: list[Delivery] = []

    def on_delivery_start(self, scene: Scene, camera: SimulatedCamera | None) -> None:  # noqa: ARG002  (as all observers)
        """Add the first frame, also of a delivery from which nothing is picked."""
        self._camera, self._next, self._doing = camera, 0.0, "takes an image of the tray"
        self.on_control_cycle(0.0)

    def on_control_cycle(self, time: float) -> None:
        """Add a frame to the film, if one is due at a time since the start of the delivery, s."""
        if self._film is not None and self._camera is not None and time >= self._next:
            self._next += 1.0 / FPS
            caption = f"delivery {len(self.deliveries) + 1}: {self._doing}"
            frame = self._camera.picture("overview")
            self._film.add(add_caption(frame, caption, f"{time:.0f} s, {self._packed} packed"))

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:  # noqa: ARG002  (as all observers)
        """Set the caption of the next frames.

        Args:
            choice: fruit and place of the pick.
            before: state of the pick in its last phase.
            after: state in its new phase.
        """
        self._doing = f"{choice.fruit.kind}: the arm {after.phase.value}"

    def on_pick_end(self, pick: Pick) -> None:
        """Count packed fruit, and set the caption of the next frames."""
        self._packed += pick.outcome is PickOutcome.PLACED
        self._doing = "chooses the next fruit"

    def on_delivery_end(self, delivery: Delivery) -> None:
        """Add the evaluated picks to the sheet, and after the first delivery its overview."""
        self.deliveries.append(delivery.without_pictures)
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            if pick.observation.picture is not None:
                self._add_tile(pick, verdict)
        if self._camera is not None and len(self.deliveries) == 1:
            final = self._camera.picture("overview")
            self.sheet.overview(final, ("the cell after its first delivery", count_noun(len(delivery.picks), "pick")))
        self._camera = None

    def _add_tile(self, pick: Pick, verdict: Verdict) -> None:
        """Add a pick to the contact sheet: its image, fruit and place, release error (mm), peak acceleration (m/s2)."""
        assert pick.observation.picture is not None  # as `on_delivery_end` checks
        fruit, place = pick.choice.fruit, pick.choice.place
        picture = draw_detections(pick.observation.picture, pick.observation.detections)
        x, y = self._calibration.to_pixels([fruit.x, fruit.y, fruit.radius]).tolist()
        error, peak = 1e3 * verdict.release_error, verdict.peak_acceleration
        packed = f"{place.container} {place.name}, error {error:.1f} mm, {peak:.0f} m/s\N{SUPERSCRIPT TWO}"
        result = packed if pick.outcome is PickOutcome.PLACED else pick.trouble
        head = f"{len(self.deliveries)}.{pick.number}: {fruit.kind}, {fruit.grade}, {1e3 * fruit.diameter:.0f} mm"
        self.sheet.add(picture, (x, y), (head, result), failed="" if verdict.correct else verdict.word(pick))


@contextmanager
def record_film_and_sheet(
    film: Path | None, sheet: Path, title: str, calibration: Calibration
) -> Iterator[FilmAndSheet]:
    """Yield an observer that makes a film and a contact sheet, which are written if the block ends without an error.

    Args:
        film: path that ends in .mp4 or .gif; None: no film.
        sheet: path that ends in .png.
        title: title of the sheet, to which the result of the picks is added.
        calibration: calibration of the camera.

    Raises:
        OutputError: a path ends otherwise, a file can't be written, or the film has no frame.
        InputError: PyAV, which encodes films, is not installed.
    """
    with nullcontext() if film is None else Film(film, FPS) as opened:
        observer = FilmAndSheet(opened, ContactSheet(title), calibration)
        yield observer
        summary = PackingSummary(observer.deliveries)
        rate = f", {summary.picks_a_minute:.1f} a minute" if summary.picks else ""
        observer.sheet.title = f"{title}: {summary.correct} of {count_noun(summary.picks, 'pick')} correct{rate}"
        observer.sheet.save(sheet)
