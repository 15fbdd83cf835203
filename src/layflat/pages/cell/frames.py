"""Images of a run as JPEG, with what the camera saw, and the choice of those that are shown: as few as can be seen."""

from collections.abc import Callable
from io import BytesIO
from math import hypot
from typing import Any, Protocol

import numpy as np
from PIL import Image

from layflat.arrays import Array, Picture
from layflat.cell.extras import opencv
from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Detection, draw
from layflat.pages.cell.snapshot import Requests, listed

QUALITY = 75  # of JPEG: 30 to 90 kB an image
SAME = 15e-3  # two detections nearer than this are of one fruit, m
WIDER = 9.0  # by which the mark is wider than a fruit, px
DARK, BRIGHT = (0, 0, 0), (255, 255, 255)


def jpeg(picture: Picture) -> bytes:
    """Return a picture, (H, W, 3) RGB, as a JPEG file."""
    written = BytesIO()
    Image.fromarray(picture).save(written, "JPEG", quality=QUALITY)
    return written.getvalue()


def drawn(observation: Observation, chosen: Fruit | None) -> Picture:
    """Return the picture of an observation that has one, with its detections, and a ring around the chosen fruit."""
    assert observation.picture is not None
    picture = draw(observation.picture, observation.detections)
    found = None if chosen is None else detection_of(observation, chosen)
    if found is not None:
        _mark(picture, found.outline)
    return picture


def detection_of(observation: Observation, fruit: Fruit) -> Detection | None:
    """Return the detection of a fruit; None where the image does not show it."""

    def away(one: Detection) -> float:
        return hypot(one.position[0] - fruit.x, one.position[1] - fruit.y)

    nearest = min(observation.detections, key=away, default=None)
    return nearest if nearest is not None and away(nearest) < SAME else None


def _mark(picture: Picture, outline: Array) -> None:
    """Draw a ring around an outline, (N, 2) px, and "chosen" above it, or below where there is no room."""
    cv2 = opencv()
    (x, y), radius = outline.mean(axis=0), float(np.linalg.norm(outline - outline.mean(axis=0), axis=1).max())
    for colour, thick in ((DARK, 8), (BRIGHT, 4)):
        cv2.circle(picture, (round(x), round(y)), round(radius + WIDER), colour, thick, cv2.LINE_AA)
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.7
    (wide, high), _ = cv2.getTextSize("chosen", font, size, 2)
    above = y - radius - 2 * WIDER
    base = above if above > high else y + radius + 2 * WIDER + high
    for colour, thick in ((DARK, 5), (BRIGHT, 2)):
        cv2.putText(picture, "chosen", (round(x - wide / 2), round(base)), font, size, colour, thick, cv2.LINE_AA)


FRAME, FAST_FRAME = 0.125, 0.2  # of real time between two overviews, at least; where the run is not to be slowed, s
UNMARKED, MARKED = 0.4, 1.0  # for so long an image of the camera is shown before another one takes its place, s


class Shows(Protocol):
    """Receiver of what is observed."""

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
        """True if it is time for an overview."""
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
