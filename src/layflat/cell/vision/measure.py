"""Measurement of round things from rough outlines: positions, sizes, colours and confidence, for all detectors.

From the outline of a ball in a picture to the ball it goes in closed form, for many at once. Rays that touch a ball of
radius r, whose middle is D away in direction c, make a cone: d . c = cos(a), sin(a) = r / D. So n = c / cos(a) solves
d . n = 1 for all rays d of the outline, a linear problem. The middle is `height_ratio` r over the plane z = h; seen
from p that is p_z + D c_z = h + height_ratio D sin(a), which gives D.

A ball that is flattened by k = height / width, its axis upright, is a ball where all heights are divided by k, and rays
that touch it still touch it there: `rays_to_balls` maps rays to that space, `rays_to_spheroids` maps them back.

There are R rays an outline; a is the half angle of the cone (rad), c the direction of the ball's middle (unit vector).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from layflat.cell.extras import Array
from layflat.cell.geometry import unit_circle
from layflat.cell.vision import edges, regions
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.detection import Detection, ProduceKind

FIT_ROUNDS = 5  # of fitting and rejecting outliers
MIN_RAYS = 5  # of a cone; below, its axis is the mean of the rays
SKIN_TOLERANCE = 0.06  # deviation of the skin's chromaticity from a thing's median, in each of r, g, b of 1
STALK_LEVEL = 0.6  # brightness below which skin is a stalk, fraction of the thing's median
EDGE_TOLERANCE = 1.2  # least tolerance of an edge's distance from its outline, px
MIN_BALL_DISTANCE = 0.8  # of two balls, fraction of that at which they touch: of nearer ones one is false
COMPLETE_FRACTION = 0.8  # visible fraction of an outline that counts as complete: touching things hide the rest


def fit_cones(rays: Array, usable: Array, roundness: Array, min_tolerance: Array) -> tuple[Array, Array, Array]:
    """Fit the cones that touch balls, by least squares without outliers.

    Args:
        rays: unit vectors to outlines, (B, R, 3).
        usable: 1 for rays that may be on the outline, 0 for others, (B, R).
        roundness: final tolerance of rays, fractions of the cone's half angle, (B,).
        min_tolerance: lower bound of the tolerance, rad, (B,).

    Returns:
        Directions of the balls' middles (B, 3), half angles (B,), rad, and weights: 1 for rays on the outline, (B, R).
    """
    weights = usable.astype(float)
    for number in range(FIT_ROUNDS):
        n = np.where((weights.sum(axis=1) < MIN_RAYS)[:, None], rays.mean(axis=1), _solve_cones(rays, weights))
        length = np.linalg.norm(n, axis=1)
        middle, half = n / length[:, None], np.arccos(1.0 / np.maximum(length, 1.0))
        deviations = np.abs(ray_angles(rays, middle) - half[:, None])
        typical = _median_deviation(deviations, weights)
        tolerance = np.maximum(
            np.maximum(min_tolerance, roundness * half), (2.5 if number < FIT_ROUNDS - 1 else 0.0) * typical
        )
        weights = usable * (deviations <= tolerance[:, None])
    return middle, half, weights


def ray_angles(rays: Array, middle: Array) -> Array:
    """Return angles between rays (B, R, 3) and directions (B, 3), rad; exact where they are small."""
    away = rays - middle[:, None]
    return np.asarray(2.0 * np.arcsin(np.minimum(np.sqrt(np.einsum("bri,bri->br", away, away)) / 2.0, 1.0)))


def locate_balls(
    middle: Array, half: Array, eye: Array, plane: float, height_ratio: Array, flattening: Array
) -> tuple[Array, Array]:
    """Locate spheroids that rest on a horizontal plane, from their cones in the space where they are balls.

    Args:
        middle: directions of the balls' middles, (B, 3) unit vectors.
        half: half angles of the cones, (B,), rad.
        eye: position of the camera, (3,), m.
        plane: height of the plane, m.
        height_ratio: height of the middle over the plane to half the diameter, (B,).
        flattening: height to width, (B,).

    Returns:
        Middles (B, 3) and half widths (B,), m, in the base frame.
    """
    eyes, sine = np.array([eye] * len(half)).reshape(-1, 3), np.sin(half)
    eyes[:, 2] /= flattening
    far = (eye[2] - plane) / (height_ratio * sine - flattening * middle[:, 2])
    middles = eyes + far[:, None] * middle
    middles[:, 2] *= flattening
    return middles, far * sine


def rays_to_balls(rays: Array, flattening: Array) -> Array:
    """Return rays (B, R, 3) to spheroids of a flattening (B,) as rays to balls, unit vectors."""
    scaled = rays / np.stack([np.ones_like(flattening), np.ones_like(flattening), flattening], axis=-1)[:, None]
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def rays_to_spheroids(rays: Array, flattening: Array) -> Array:
    """Return rays (B, R, 3) to balls as rays to spheroids of a flattening (B,): the inverse of `rays_to_balls`."""
    return rays_to_balls(rays, 1.0 / flattening)


def cone_rays(middle: Array, half: Array, count: int) -> Array:
    """Return equidistant rays on cones, (B, count, 3) unit vectors, all the way round from the same side.

    The first ray lies in the direction of axis x y, which is +x of an axis along -z; from there they turn to +y.

    Args:
        middle: directions of the cones' axes, (B, 3) unit vectors, none parallel to y.
        half: half angles, (B,), rad.
        count: number of rays of a cone.
    """
    side = np.cross(middle, np.array([0.0, 1.0, 0.0]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(side, middle)
    cosine, sine = unit_circle(count).T
    around = cosine[None, :, None] * side[:, None] + sine[None, :, None] * other[:, None]
    return np.asarray(np.cos(half)[:, None, None] * middle[:, None] + np.sin(half)[:, None, None] * around)


def _solve_cones(rays: Array, weights: Array) -> Array:
    """Return the vectors x (B, 3) that solve rays (B, R, 3) @ x = 1 by least squares with weights (B, R)."""
    weighed = (rays * weights[..., None]).transpose(0, 2, 1)
    A, b = weighed @ rays, weighed.sum(axis=2)
    ridge = 1e-12 * np.maximum(weights.sum(axis=1), 1.0)
    return np.asarray(np.linalg.solve(A + ridge[:, None, None] * np.eye(3), b[..., None])[..., 0])


def _median_deviation(off: Array, weights: Array) -> Array:
    """Return the lower median of the deviations of rays with a weight, (B,); 0 where there are none."""
    used = np.sort(np.where(weights > 0.0, off, np.inf), axis=1)
    middle = np.maximum(weights.sum(axis=1).astype(int) - 1, 0) // 2
    typical = np.take_along_axis(used, middle[:, None], axis=1)[:, 0]
    return np.asarray(np.where(np.isfinite(typical), typical, 0.0))


class Measurements(NamedTuple):
    """Measurements of things, a row for each."""

    middles: Array  # in the base frame (B, 3), m
    radii: Array  # m
    outlines: Array  # (B, RAY_COUNT, 2), px
    edge_fractions: Array  # fraction of each outline that is an edge in the picture
    colours: Array  # mean RGB (B, 3), of 255, stalks and reflections left out


def measure_things(
    picture: Any,
    even: Any,
    calibration: Calibration,
    places: Array,
    usable: Array,
    kinds: Sequence[ProduceKind],
    plane: float,
) -> Measurements:
    """Measure things as spheroids on a plane, from rough outlines, then twice from edges in the picture.

    Args:
        picture: RGB, as taken.
        even: the same at half the resolution with normalized light.
        calibration: calibration of the camera.
        places: points on outlines, (B, R, 2), px.
        usable: flags of points that may be on the outline, (B, R).
        kinds: assumed kind of each thing.
        plane: height of the floor on which they lie, m.
    """
    roundness = np.array([kind.roundness for kind in kinds])
    flattening = np.array([kind.flattening for kind in kinds])
    # Where heights are divided by the flattening, angles about a camera that looks down shrink with it.
    min_tolerance = flattening * EDGE_TOLERANCE / float(calibration.matrix[0, 0])
    eye = calibration.position

    def outlined() -> Array:
        rays = rays_to_spheroids(cone_rays(middle, half, edges.RAY_COUNT), flattening)
        return calibration.to_pixels(eye + rays)

    rays = rays_to_balls(calibration.rays(places), flattening)
    middle, half, _ = fit_cones(rays, usable, 2.0 * roundness, 2.0 * min_tolerance)
    for _ in range(2):
        at, edge = edges.find_picture_edges(picture, outlined())
        middle, half, on = fit_cones(rays_to_balls(calibration.rays(at), flattening), edge, roundness, min_tolerance)
    ratio = np.array([kind.height_ratio for kind in kinds])
    middles, radii = locate_balls(middle, half, eye, plane, ratio, flattening)
    outlines = outlined()
    _, level, skin, values = _sample_skins(even, outlines)
    dull = skin & (level <= np.sort(level, axis=1)[:, -level.shape[1] // 10, None])
    colours = (values * dull[..., None]).sum(axis=1) / np.maximum(dull.sum(axis=1, keepdims=True), 1)
    return Measurements(middles, radii, outlines, on.mean(axis=1), colours)


def select_detections(names: Sequence[str | None], measured: Measurements, sure: Array, good: Array) -> list[Detection]:
    """Return the accepted detections by confidence, one at each position, of a known kind where there is one.

    Args:
        names: names of the kinds, None for an unknown one.
        measured: measurements, a row for each.
        sure: confidences, (B,).
        good: flags of accepted rows, (B,).
    """
    unknown = np.array([name is None for name in names])
    order = np.flatnonzero(good)
    order = order[np.lexsort((-sure[order], unknown[order]))]
    rows = np.column_stack([measured.middles[order, :2], np.maximum(measured.radii[order], 0.0), order])
    kept = regions.suppress_neighbours(rows, MIN_BALL_DISTANCE)[:, 3].astype(int)
    selected = []
    for number in kept[np.argsort(-sure[kept], kind="stable")]:
        position, colour = measured.middles[number], np.clip(measured.colours[number], 0.0, 255.0)
        diameter, outline = 2.0 * float(measured.radii[number]), measured.outlines[number]
        fields = tuple(position.tolist()), diameter, tuple(colour.tolist()), float(sure[number]), outline
        selected.append(Detection(names[number], *fields))
    return selected


def inner_points(outlines: Array) -> Array:
    """Return points spread evenly within outlines (px), in px of the halved picture, (B, 8, RAY_COUNT / 4, 2)."""
    shares = np.sqrt(np.linspace(0.04, 0.75, 8))
    middle = outlines.mean(axis=1)[:, None, None]
    return np.asarray((middle + shares[:, None, None] * (outlines[:, None, ::4] - middle) - 0.5) / 2.0)


def radial_relief(even: Any, outlines: Array, presence: Array) -> Array:
    """Return the radial darkening of things, (B,): its standard deviation as a fraction of the mean brightness.

    It is nearly 0 for flat things, even if one side is brighter, and negative for a bright rim.

    Args:
        even: picture at half the resolution with normalized light.
        outlines: (B, RAY_COUNT, 2), px of the whole picture.
        presence: 0 to 1 for each of `inner_points`, without background and neighbours, (B, 8, RAY_COUNT / 4).
    """
    places, level, skin, _ = _sample_skins(even, outlines)
    # A dark stalk in the middle, of the skin's chromaticity, would pass for a hollow.
    weights = skin * presence.reshape(skin.shape) * (level > STALK_LEVEL * np.median(level, axis=1, keepdims=True))
    at = (places - places.mean(axis=(1, 2), keepdims=True)).reshape(len(outlines), -1, 2)
    at /= np.maximum(np.abs(at).max(axis=(1, 2), keepdims=True), 1e-9)
    x, y = at[..., 0], at[..., 1]
    basis = np.stack([np.ones_like(x), x, y, x * x + y * y], axis=-1)
    weighed = (basis * weights[..., None]).transpose(0, 2, 1)
    terms = np.linalg.solve(weighed @ basis + 1e-6 * np.eye(4), weighed @ level[..., None])
    return np.asarray(-terms[:, 3, 0] * basis[..., 3].std(axis=1) / np.maximum(level.mean(axis=1), 1.0))


def _sample_skins(even: Any, outlines: Array) -> tuple[Array, Array, Array, Array]:
    """Return `inner_points`, their brightness and flags of the skin's (median) chromaticity, (B, points), and RGB."""
    places = inner_points(outlines)
    values = edges.sample_picture(even, places).reshape(len(outlines), -1, 3)
    level = values.mean(axis=2)
    shade = values / np.maximum(3.0 * level, 1.0)[..., None]
    skin = np.abs(shade - np.median(shade, axis=1, keepdims=True)).max(axis=2) < SKIN_TOLERANCE
    return places, level, skin, values
