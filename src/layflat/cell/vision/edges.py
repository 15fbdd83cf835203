"""Edge detection of round things: along rays from the middle in a mask, then across the outline in a picture."""

from typing import Any

import numpy as np

from layflat.cell.extras import Array, opencv
from layflat.cell.geometry import unit_circle

RAY_COUNT = 60  # rays around a thing, and points of an outline
RAY_SAMPLES = 40  # along a ray from the middle
PROFILE_OFFSETS = np.arange(-5.0, 5.01, 1.0, dtype=np.float32)  # of samples across an outline, px, outwards
INSIDE_SAMPLES = PROFILE_OFFSETS <= -4.0
MIN_CONTRAST = 24.0  # distance of colours across an edge, of 441
MIN_HUE_CONTRAST = 12.0  # distance perpendicular to the inside's colour, from which more than brightness differs


def sample_picture(picture: Any, places: Array) -> Array:
    """Return a picture's values at points (..., 2), px, interpolated between pixels; 0 outside."""
    cv2 = opencv()
    flat = places.reshape(len(places), -1, 2).astype(np.float32)
    values = cv2.remap(picture, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return np.asarray(values, dtype=np.float32).reshape(*places.shape[:-1], *picture.shape[2:])


def find_mask_edges(mask: Any, middles: Array, nearest: Array, farthest: Array) -> tuple[Array, Array]:
    """Detect where rays from middles first leave a mask, between two distances.

    Args:
        mask: mask of 0 and 255.
        middles: origins of the rays, (B, 2), px.
        nearest: start of the search, (B,), px.
        farthest: end of the search, (B,), px.

    Returns:
        Points (B, RAY_COUNT, 2), px, and flags of those that are edges, (B, RAY_COUNT).
    """
    ahead = unit_circle(RAY_COUNT)
    far = nearest[:, None] + (farthest - nearest)[:, None] * np.linspace(0.0, 1.0, RAY_SAMPLES)
    values = sample_picture(mask, middles[:, None, None] + far[:, None, :, None] * ahead[None, :, None])
    outside = values < 127.5
    first = outside.argmax(axis=2)
    usable = outside.any(axis=2) & (first > 0)
    last = np.maximum(first, 1) - 1
    before, after = (np.take_along_axis(values, at[..., None], axis=2)[..., 0] for at in (last, last + 1))
    share = np.where(usable, (before - 127.5) / np.maximum(before - after, 1e-6), 0.0)
    step = ((farthest - nearest) / (RAY_SAMPLES - 1))[:, None]
    radius = nearest[:, None] + step * (last + share)
    return middles[:, None] + radius[..., None] * ahead, usable


def find_picture_edges(picture: Any, outlines: Array) -> tuple[Array, Array]:
    """Detect the edges near outlines: where the colour is halfway between inside and outside.

    The outside is the colour that differs most from the inside, so that a narrow gap between two things is detected.
    The outlines (B, RAY_COUNT, 2), px, go anticlockwise in the RGB picture. Return as `find_mask_edges`;
    points that are no edges stay on the outlines.
    """
    along = np.roll(outlines, -1, axis=1) - np.roll(outlines, 1, axis=1)
    outwards = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    outwards /= np.maximum(np.linalg.norm(outwards, axis=-1, keepdims=True), 1e-9)
    values = sample_picture(picture, outlines[..., None, :] + PROFILE_OFFSETS[:, None] * outwards[..., None, :])
    share, clear = _outside_fraction(values)
    beyond = (share >= 0.5) & ~INSIDE_SAMPLES
    first = beyond.argmax(axis=2)
    last = np.maximum(first - 1, 0)
    low, high = (np.take_along_axis(share, at[..., None], axis=2)[..., 0] for at in (last, first))
    spot = PROFILE_OFFSETS[last] + (0.5 - low) / np.maximum(high - low, 1e-6) * (
        PROFILE_OFFSETS[1] - PROFILE_OFFSETS[0]
    )
    rows, columns = picture.shape[:2]
    framed = ((outlines >= 6.0) & (outlines <= [columns - 7.0, rows - 7.0])).all(axis=-1)
    usable = clear & (first > 0) & framed
    return outlines + np.where(usable, spot, 0.0)[..., None] * outwards, usable


def _outside_fraction(values: Array) -> tuple[Array, Array]:
    """Return the fraction of the outside's colour in values across outlines, (..., A, 3), and flags of edges.

    A pixel on an edge is s f + b o, with the inside's colour f, its brightness s, the outside's colour o, and the
    fraction b. A ball gets darker towards its rim, which is no edge; so s is free where the two colours differ in more
    than brightness, and 1 - b elsewhere.
    """
    f = values[..., INSIDE_SAMPLES, :].mean(axis=-2)
    ff = np.einsum("brc,brc->br", f, f)[..., None] + 1e-3
    along = np.einsum("brac,brc->bra", values, f)
    square = np.einsum("brac,brac->bra", values, values)
    hue_differs = square - along**2 / ff
    differs = square - 2.0 * along + ff
    weighed = hue_differs + 0.05 * differs
    weighed[..., INSIDE_SAMPLES] = -1.0
    at = weighed.argmax(axis=-1)[..., None]
    o = np.take_along_axis(values, at[..., None], axis=-2)[..., 0, :]
    oo, fo, apart, most = (np.take_along_axis(table, at, axis=-1) for table in (square, along, hue_differs, differs))
    with_o = np.einsum("brac,brc->bra", values, o)
    free = (ff * with_o - fo * along) / np.maximum(ff * oo - fo**2, 1e-3)
    fixed = (ff - along - fo + with_o) / np.maximum(most, 1e-3)
    coloured = apart > MIN_HUE_CONTRAST**2
    return np.where(coloured, free, fixed), (most > MIN_CONTRAST**2)[..., 0] | coloured[..., 0]
