"""A run to look at: a film of the cell, and a sheet with the picture by which each pick was chosen."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from layflat.cell.camera import Camera
from layflat.cell.pictures import ContactSheet, Film, captioned
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Outcome, State
from layflat.cell.scene import Scene
from layflat.cell.vision import Calibration, draw
from layflat.cell.work.delivery import Delivery, Onlooker
from layflat.cell.work.packer import Pick
from layflat.cell.work.results import summary

FPS = 10.0
"""Frames of a film a second of the cell's time."""


@contextmanager
def shown(film: Path | None, sheet: Path, title: str, calibration: Calibration) -> Iterator[Show]:
    """An onlooker that leaves a film and a contact sheet, if the block ends well.

    Args:
        film: where to, .mp4 or .gif; None for no film.
        sheet: where to, .png.
        title: of the sheet; what came of the picks is added.
        calibration: of the camera.

    Raises:
        OutputError: they can't be written there.
    """
    with nullcontext() if film is None else Film(film, FPS) as opened:
        show = Show(opened, ContactSheet(title), calibration)
        yield show
        show.sheet.title = f"{title}: {show.told}"
        show.sheet.save(sheet)


class Show(Onlooker):
    """An onlooker that makes a film and a contact sheet.

    Args:
        film: open; None for no film.
        sheet: to which each pick is added.
        calibration: of the camera.
    """

    def __init__(self, film: Film | None, sheet: ContactSheet, calibration: Calibration) -> None:
        self._film, self.sheet, self._calibration = film, sheet, calibration
        self._camera: Camera | None = None
        self._next = 0.0
        self._doing, self._packed = "looks at the tray", 0
        self._deliveries: list[Delivery] = []

    @property
    def told(self) -> str:
        """What came of all picks so far."""
        found = summary(self._deliveries)
        return f"{found.right} of {found.picks} picks right, {found.picks_a_minute:.1f} a minute"

    def begins(self, scene: Scene, camera: Camera | None) -> None:  # noqa: ARG002  (as all onlookers)
        """A delivery begins."""
        self._camera, self._next, self._doing = camera, 0.0, "looks at the tray"
        self.cycle(0.0)  # also of a tray from which nothing is picked

    def cycle(self, time: float) -> None:
        """A frame, if it is time for one."""
        if self._film is not None and self._camera is not None and time >= self._next:
            self._next += 1.0 / FPS
            left = f"delivery {len(self._deliveries) + 1}: {self._doing}"
            frame = self._camera.picture("overview")
            self._film.add(captioned(frame, left, f"{time:.0f} s, {self._packed} packed"))

    def phase(self, choice: Choice, before: State, after: State) -> None:  # noqa: ARG002  (as all onlookers)
        """What the next frames show."""
        self._doing = f"{choice.fruit.kind}: {after.phase.value}"

    def picked(self, pick: Pick) -> None:
        """A pick has ended."""
        self._packed += pick.outcome is Outcome.PLACED
        self._doing = "looks for the next fruit"

    def ends(self, delivery: Delivery) -> None:
        """Now that it is judged, its picks come on the sheet."""
        self._deliveries.append(delivery.without_pictures)
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            sight, fruit, spot = pick.sight, pick.choice.fruit, pick.choice.spot
            if sight.picture is None:
                continue
            picture = draw(sight.picture, sight.detections)
            x, y = self._calibration.to_pixels([fruit.x, fruit.y, fruit.radius]).tolist()
            failed = "" if verdict.right else verdict.told(pick)
            off, peak = 1e3 * verdict.release_error, verdict.peak_acceleration
            result = f"{spot.pack} {spot.place.name}, {off:.1f} mm off, {peak:.0f} m/s\N{SUPERSCRIPT TWO}"
            if pick.outcome is not Outcome.PLACED:
                result = pick.trouble
            head = f"{len(self._deliveries)}.{pick.number}: {fruit.kind}, {fruit.grade}, {1e3 * fruit.diameter:.0f} mm"
            self.sheet.add(picture, (x, y), (head, result), failed=failed)
        if self._camera is not None and len(self._deliveries) == 1:
            final = self._camera.picture("overview")
            self.sheet.overview(final, ("the cell after its first delivery", f"{len(delivery.picks)} picks"))
        self._camera = None
