"""Images of a run: a film of the cell, and a sheet with the image by which each pick was chosen."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from layflat.cell.pictures import ContactSheet, Film, captioned
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Outcome, State
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration, draw
from layflat.cell.work.observer import Observer
from layflat.cell.work.records import Delivery, Pick, Verdict
from layflat.cell.work.results import Summary, counted

FPS = 10.0  # frames of a film a second of the cell's time


class FilmAndSheet(Observer):
    """Makes a film, if one is open, and a contact sheet."""

    def __init__(self, film: Film | None, sheet: ContactSheet, calibration: Calibration) -> None:
        self._film, self.sheet, self._calibration = film, sheet, calibration
        self._camera: SimulatedCamera | None = None
        self._next = 0.0
        self._doing, self._packed = "takes an image of the tray", 0
        self.deliveries: list[Delivery] = []

    def begins(self, scene: Scene, camera: SimulatedCamera | None) -> None:  # noqa: ARG002  (as all observers)
        """Film also a tray from which nothing is picked."""
        self._camera, self._next, self._doing = camera, 0.0, "takes an image of the tray"
        self.cycle(0.0)

    def cycle(self, time: float) -> None:
        """Add a frame, if it is time for one."""
        if self._film is not None and self._camera is not None and time >= self._next:
            self._next += 1.0 / FPS
            left = f"delivery {len(self.deliveries) + 1}: {self._doing}"
            frame = self._camera.picture("overview")
            self._film.add(captioned(frame, left, f"{time:.0f} s, {self._packed} packed"))

    def phase(self, choice: Choice, before: State, after: State) -> None:  # noqa: ARG002  (as all observers)
        """Note what the next frames show."""
        self._doing = f"{choice.fruit.kind}: the arm {after.phase.value}"

    def picked(self, pick: Pick) -> None:
        """Count what is packed."""
        self._packed += pick.outcome is Outcome.PLACED
        self._doing = "chooses the next fruit"

    def ends(self, delivery: Delivery) -> None:
        """Put the picks, now that they are evaluated, on the sheet."""
        self.deliveries.append(delivery.without_pictures)
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            if pick.observation.picture is not None:
                self._add(pick, verdict)
        if self._camera is not None and len(self.deliveries) == 1:
            final = self._camera.picture("overview")
            self.sheet.overview(final, ("the cell after its first delivery", counted(len(delivery.picks), "pick")))
        self._camera = None

    def _add(self, pick: Pick, verdict: Verdict) -> None:
        assert pick.observation.picture is not None  # as `ends` checks
        fruit, place = pick.choice.fruit, pick.choice.place
        picture = draw(pick.observation.picture, pick.observation.detections)
        x, y = self._calibration.to_pixels([fruit.x, fruit.y, fruit.radius]).tolist()
        error, peak = 1e3 * verdict.release_error, verdict.peak_acceleration
        packed = f"{place.container} {place.name}, error {error:.1f} mm, {peak:.0f} m/s\N{SUPERSCRIPT TWO}"
        result = packed if pick.outcome is Outcome.PLACED else pick.trouble
        head = f"{len(self.deliveries)}.{pick.number}: {fruit.kind}, {fruit.grade}, {1e3 * fruit.diameter:.0f} mm"
        self.sheet.add(picture, (x, y), (head, result), failed="" if verdict.correct else verdict.word(pick))


@contextmanager
def film_and_sheet(film: Path | None, sheet: Path, title: str, calibration: Calibration) -> Iterator[FilmAndSheet]:
    """Give an observer that leaves a film (.mp4, .gif or None) and a contact sheet (.png), if the block ends well.

    What came of the picks is added to the title of the sheet. Raises OutputError where they can't be written.
    """
    with nullcontext() if film is None else Film(film, FPS) as opened:
        observer = FilmAndSheet(opened, ContactSheet(title), calibration)
        yield observer
        found = Summary(observer.deliveries)
        rate = f", {found.picks_a_minute:.1f} a minute" if found.picks else ""
        observer.sheet.title = f"{title}: {found.correct} of {counted(found.picks, 'pick')} correct{rate}"
        observer.sheet.save(sheet)
