"""From rough outlines to places, sizes, colours and confidence: the part that all detectors share."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from layflat.cell.vision import balls, edges, regions
from layflat.cell.vision.boards import Array
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.detection import Detection, Kind

STALK = 0.06  # how far a chromaticity, in each of r, g, b of 1, may be from a thing's median to be of its skin
STALK_LEVEL = 0.6  # brightness under which a thing's skin is a stalk, share of its median
DUST = 1.2  # px that an edge may be off its outline in any case
BALLS_APART = 0.8  # least distance of two balls, as a share of that at which they touch: what is nearer is none
COMPLETE = 0.8  # share of an outline from which it is as good as whole: what touches others is never seen all around


class Measured(NamedTuple):
    """What is known of things, one a row."""

    middles: Array  # in the base frame (B, 3), m
    radii: Array  # m
    outlines: Array  # (B, AROUND, 2), px
    seen: Array  # share of each outline that is an edge in the picture
    colours: Array  # mean RGB (B, 3), of 255, stalks and reflections left out


def measure(
    picture: Any, even: Any, calibration: Calibration, places: Array, usable: Array, kinds: Sequence[Kind], plane: float
) -> Measured:
    """Measure things as balls on the table, from rough places on their outlines, then twice from edges in the picture.

    Args:
        picture: RGB, as taken.
        even: its half, evenly lit.
        calibration: of the camera.
        places: on outlines, (B, R, 2), px.
        usable: which of them may be used, (B, R).
        kinds: what each may be.
        plane: height of what they rest on, m.
    """
    roundness = np.array([kind.roundness for kind in kinds])
    flattening = np.array([kind.flattening for kind in kinds])
    # Where heights are divided by the flattening, angles about a camera that looks down shrink with it.
    least = flattening * DUST / float(calibration.matrix[0, 0])
    eye = calibration.position

    def outlined() -> Array:
        rays = balls.flattened(balls.cone_rays(middle, half, edges.AROUND), flattening)
        return calibration.to_pixels(eye + rays)

    rays = balls.upright(calibration.rays(places), flattening)
    middle, half, _ = balls.fit_cones(rays, usable, 2.0 * roundness, 2.0 * least)
    for _ in range(2):
        at, edge = edges.edges_of_picture(picture, outlined())
        middle, half, on = balls.fit_cones(balls.upright(calibration.rays(at), flattening), edge, roundness, least)
    ratio = np.array([kind.height_ratio for kind in kinds])
    middles, radii = balls.place(middle, half, eye, plane, ratio, flattening)
    outlines = outlined()
    _, level, skin, values = _skins(even, outlines)
    dull = skin & (level <= np.sort(level, axis=1)[:, -level.shape[1] // 10, None])
    colours = (values * dull[..., None]).sum(axis=1) / np.maximum(dull.sum(axis=1, keepdims=True), 1)
    return Measured(middles, radii, outlines, on.mean(axis=1), colours)


def detections(names: Sequence[str | None], measured: Measured, sure: Array, good: Array) -> list[Detection]:
    """Return what is `good`, the most `sure` first; at one place that only, and of a known kind if any is.

    The name of an unknown kind is None.
    """
    unknown = np.array([name is None for name in names])
    order = np.flatnonzero(good)
    order = order[np.lexsort((-sure[order], unknown[order]))]
    rows = np.column_stack([measured.middles[order, :2], np.maximum(measured.radii[order], 0.0), order])
    kept = regions.apart(rows, BALLS_APART)[:, 3].astype(int)
    found = []
    for number in kept[np.argsort(-sure[kept], kind="stable")]:
        position, colour = measured.middles[number], np.clip(measured.colours[number], 0.0, 255.0)
        diameter, outline = 2.0 * float(measured.radii[number]), measured.outlines[number]
        shown = tuple(position.tolist()), diameter, tuple(colour.tolist()), float(sure[number]), outline
        found.append(Detection(names[number], *shown))
    return found


def inside(outlines: Array) -> Array:
    """Return places evenly spread within outlines, px of the halved picture, (B, 8, AROUND / 4, 2)."""
    shares = np.sqrt(np.linspace(0.04, 0.75, 8))
    middle = outlines.mean(axis=1)[:, None, None]
    return np.asarray((middle + shares[:, None, None] * (outlines[:, None, ::4] - middle) - 0.5) / 2.0)


def relief(even: Any, outlines: Array, own: Array) -> Array:
    """Return how much darker things get from their middle outwards, (B,): standard deviation as a share of their mean.

    Nearly 0 for what is flat, even where it is brighter on one side. Ground and neighbours within an outline are left
    out by `own`: how much of the thing is at each place of `inside`, 0 to 1.
    """
    places, level, skin, _ = _skins(even, outlines)
    # A dark stalk in the middle, of the skin's chromaticity, would pass for a hollow.
    weights = skin * own.reshape(skin.shape) * (level > STALK_LEVEL * np.median(level, axis=1, keepdims=True))
    at = (places - places.mean(axis=(1, 2), keepdims=True)).reshape(len(outlines), -1, 2)
    at /= np.maximum(np.abs(at).max(axis=(1, 2), keepdims=True), 1e-9)
    x, y = at[..., 0], at[..., 1]
    basis = np.stack([np.ones_like(x), x, y, x * x + y * y], axis=-1)
    weighed = (basis * weights[..., None]).transpose(0, 2, 1)
    terms = np.linalg.solve(weighed @ basis + 1e-6 * np.eye(4), weighed @ level[..., None])
    return np.asarray(-terms[:, 3, 0] * basis[..., 3].std(axis=1) / np.maximum(level.mean(axis=1), 1.0))


def _skins(even: Any, outlines: Array) -> tuple[Array, Array, Array, Array]:
    """Return places within outlines, brightness there, where the chromaticity is that of most, and the values."""
    places = inside(outlines)
    values = edges.sampled(even, places).reshape(len(outlines), -1, 3)
    level = values.mean(axis=2)
    shade = values / np.maximum(3.0 * level, 1.0)[..., None]
    skin = np.abs(shade - np.median(shade, axis=1, keepdims=True)).max(axis=2) < STALK
    return places, level, skin, values
