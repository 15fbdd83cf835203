"""Where the edges of round things are: along rays from a middle in a mask, then across an outline in the picture."""

from typing import Any

import numpy as np

from layflat.cell.extras import opencv
from layflat.cell.geometry import unit_circle
from layflat.cell.vision.boards import Array

AROUND = 60  # rays of an outline
STEPS = 40  # looks along a ray from a middle
ACROSS = np.arange(-5.0, 5.01, 1.0, dtype=np.float32)  # looks across an outline, px, outwards
INSIDE = ACROSS <= -4.0
CONTRAST = 24.0  # distance of colours, of 441, from which an edge is one
COLOURED = 12.0  # distance across the inside's colour from which two colours differ in more than brightness


def sampled(picture: Any, places: Array) -> Array:
    """Return a picture's values at places (..., 2), px, between its pixels; 0 outside."""
    cv2 = opencv()
    flat = places.reshape(len(places), -1, 2).astype(np.float32)
    values = cv2.remap(picture, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return np.asarray(values, dtype=np.float32).reshape(*places.shape[:-1], *picture.shape[2:])


def edges_of_mask(mask: Any, middles: Array, nearest: Array, farthest: Array) -> tuple[Array, Array]:
    """Find where rays from middles (B, 2) first leave a mask of 0 and 255, between two distances (B,); all in px.

    Returns:
        Places (B, AROUND, 2), px, and whether there is an edge, (B, AROUND).
    """
    ahead = unit_circle(AROUND)
    far = nearest[:, None] + (farthest - nearest)[:, None] * np.linspace(0.0, 1.0, STEPS)
    values = sampled(mask, middles[:, None, None] + far[:, None, :, None] * ahead[None, :, None])
    outside = values < 127.5
    first = outside.argmax(axis=2)
    usable = outside.any(axis=2) & (first > 0)
    last = np.maximum(first, 1) - 1
    before, after = (np.take_along_axis(values, at[..., None], axis=2)[..., 0] for at in (last, last + 1))
    share = np.where(usable, (before - 127.5) / np.maximum(before - after, 1e-6), 0.0)
    step = ((farthest - nearest) / (STEPS - 1))[:, None]
    radius = nearest[:, None] + step * (last + share)
    return middles[:, None] + radius[..., None] * ahead, usable


def edges_of_picture(picture: Any, outlines: Array) -> tuple[Array, Array]:
    """Find where colour changes halfway from inside to outside, near outlines.

    What is outside is the colour that differs most from the inside, so that a narrow gap between two things is found.
    The outlines (B, AROUND, 2), px, go anticlockwise in the RGB picture. Returns as `edges_of_mask`.
    """
    along = np.roll(outlines, -1, axis=1) - np.roll(outlines, 1, axis=1)
    outwards = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    outwards /= np.maximum(np.linalg.norm(outwards, axis=-1, keepdims=True), 1e-9)
    values = sampled(picture, outlines[..., None, :] + ACROSS[:, None] * outwards[..., None, :])
    share, clear = _outside_share(values)
    beyond = (share >= 0.5) & ~INSIDE
    first = beyond.argmax(axis=2)
    last = np.maximum(first - 1, 0)
    low, high = (np.take_along_axis(share, at[..., None], axis=2)[..., 0] for at in (last, first))
    spot = ACROSS[last] + (0.5 - low) / np.maximum(high - low, 1e-6) * (ACROSS[1] - ACROSS[0])
    rows, columns = picture.shape[:2]
    framed = ((outlines >= 6.0) & (outlines <= [columns - 7.0, rows - 7.0])).all(axis=-1)
    usable = clear & (first > 0) & framed
    return outlines + np.where(usable, spot, 0.0)[..., None] * outwards, usable


def _outside_share(values: Array) -> tuple[Array, Array]:
    """Return how much of what is seen across outlines, (..., A, 3), is the outside, and where there is an edge.

    A pixel on an edge is s f + b o: the inside's colour f as far as it is lit there, the outside's colour o, and b is
    sought. A ball gets darker to its rim, which must not pass for an edge; so s is free where the two differ in more
    than brightness, and 1 - b elsewhere.
    """
    f = values[..., INSIDE, :].mean(axis=-2)
    ff = np.einsum("brc,brc->br", f, f)[..., None] + 1e-3
    along = np.einsum("brac,brc->bra", values, f)
    square = np.einsum("brac,brac->bra", values, values)
    hue_differs = square - along**2 / ff
    differs = square - 2.0 * along + ff
    weighed = hue_differs + 0.05 * differs
    weighed[..., INSIDE] = -1.0
    at = weighed.argmax(axis=-1)[..., None]
    o = np.take_along_axis(values, at[..., None], axis=-2)[..., 0, :]
    oo, fo, apart, most = (np.take_along_axis(table, at, axis=-1) for table in (square, along, hue_differs, differs))
    with_o = np.einsum("brac,brc->bra", values, o)
    free = (ff * with_o - fo * along) / np.maximum(ff * oo - fo**2, 1e-3)
    fixed = (ff - along - fo + with_o) / np.maximum(most, 1e-3)
    coloured = apart > COLOURED**2
    return np.where(coloured, free, fixed), (most > CONTRAST**2)[..., 0] | coloured[..., 0]
