"""Images for the page: JPEG, and what the camera saw with its detections and the fruit that was chosen."""

from io import BytesIO
from math import hypot

import numpy as np
from PIL import Image

from layflat.arrays import Array, Picture
from layflat.cell.extras import opencv
from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit
from layflat.cell.vision import Detection, draw

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
