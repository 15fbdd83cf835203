"""Which images of a run are shown, and when: as few as can be seen, so that the run is hardly slowed."""

from collections.abc import Callable
from typing import Any, Protocol

from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit
from layflat.cell.scene.camera import SimulatedCamera
from layflat.pages.cell.pictures import drawn, jpeg
from layflat.pages.cell.snapshot import Requests, listed

FRAME, FAST_FRAME = 0.125, 0.2  # of real time between two overviews, at least; where the run is not to be slowed, s
UNMARKED, MARKED = 0.4, 1.0  # for so long an image of the camera is shown before another one takes its place, s


class Shows(Protocol):
    """Where what is observed is shown."""

    asked: Requests

    def show(self, **changes: Any) -> None:
        """Change fields of the snapshot."""

    def image(self, name: str, jpeg: bytes) -> None:
        """Replace the image "overview" or "camera"."""


class Frames:
    """Overviews of the cell, and what its camera saw; `now` is a clock of real time, s."""

    def __init__(self, shows: Shows, now: Callable[[], float]) -> None:
        self._shows, self._now = shows, now
        self._camera: SimulatedCamera | None = None
        self._frame_at = self._image_at = 0.0  # when the next is due, s
        self._last: Observation | None = None
        self._waits = False  # whether it has not been shown yet
        self._chosen: Fruit | None = None

    def begin(self, camera: SimulatedCamera | None) -> None:
        """Begin with a delivery; there is no camera where no image can be rendered."""
        self._camera, self._chosen = camera, None

    def end(self) -> None:
        """End with a delivery, with all that was seen."""
        self._image_at = 0.0
        self.show()
        self._camera = self._last = None

    @property
    def due(self) -> bool:
        """Whether it is time for an overview."""
        return self._now() >= self._frame_at

    def show(self) -> None:
        """Show the cell as it is, and what its camera saw if the image before has been seen."""
        self._frame_at = self._now() + (FAST_FRAME if self._shows.asked.fast else FRAME)
        if self._camera is not None:
            self._shows.image("overview", jpeg(self._camera.picture("overview")))
        if self._waits and self._now() >= self._image_at:
            self._show_image()

    def observe(self, observation: Observation) -> None:
        """Show an image of the camera, now or once the one before has been seen."""
        self._last, self._waits, self._chosen = observation, True, None
        if self._now() >= self._image_at:
            self._show_image()

    def choose(self, fruit: Fruit, observation: Observation) -> None:
        """Show the image by which a fruit was chosen, with a ring around it."""
        self._last, self._chosen = observation, fruit
        self._show_image()

    def _show_image(self) -> None:
        seen, self._waits = self._last, False
        if seen is None:
            return
        self._image_at = self._now() + (UNMARKED if self._chosen is None else MARKED)
        if seen.picture is not None:
            self._shows.image("camera", jpeg(drawn(seen, self._chosen)))
        self._shows.show(seen=listed(fruit.kind for fruit in seen.fruits))
