from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.cell.vision import edges
from layflat.cell.vision.colour import MIN_RELIEF
from layflat.cell.vision.measure import inner_points, radial_relief

RADIUS = 33.0
TURN = 2.0 * np.pi * np.arange(edges.RAY_COUNT) / edges.RAY_COUNT
OUTLINE = (100.0 + RADIUS * np.stack([np.cos(TURN), np.sin(TURN)], axis=-1))[None]
X, Y = np.meshgrid(2.0 * np.arange(100) + 0.5 - 100.0, 2.0 * np.arange(100) + 0.5 - 100.0)
FAR = np.hypot(X, Y) / RADIUS
ALL = np.ones((1, 8, edges.RAY_COUNT // 4))


def seen(level: NDArray[np.float64], own: NDArray[np.float64] = ALL) -> float:
    """Relief of a cream thing whose brightness (100, 100), of 1, is given on the halved picture."""
    even = np.clip(level[..., None] * np.array([230.0, 222.0, 205.0]), 0, 255).astype(np.uint8)
    return float(radial_relief(even, OUTLINE, own)[0])


def test_a_ball_and_a_flat_cap_have_relief_in_soft_light() -> None:
    for flattening in (1.0, 0.58):
        z = np.sqrt(np.maximum(1.0 - FAR**2, 0.0))
        upwards = (z / flattening) / np.hypot(FAR, z / flattening)
        assert seen(0.5 + 0.45 * upwards) > 1.5 * MIN_RELIEF


def test_a_dark_stalk_is_no_hollow() -> None:
    dome = 0.75 + 0.2 * np.sqrt(np.maximum(1.0 - FAR**2, 0.0))
    assert seen(np.where(FAR < 0.26, 0.35, dome)) > 0.9 * seen(dome)


def test_what_is_brighter_on_one_side_is_flat() -> None:
    assert abs(seen(np.full_like(X, 0.9))) < 0.1 * MIN_RELIEF
    assert abs(seen(0.8 + 0.1 * X / RADIUS)) < 0.3 * MIN_RELIEF
    assert abs(seen(np.where(X > 3.0, 0.95, 0.75))) < 0.5 * MIN_RELIEF


def test_ground_within_the_outline_tells_nothing() -> None:
    """A label half as wide as the circle around it, on a darker ground of nearly its chromaticity."""
    label = np.abs(Y) < 0.5 * RADIUS
    level = np.where(label, 0.9, 0.62)
    own = edges.sample_picture((255 * label).astype(np.uint8), inner_points(OUTLINE)) / 255.0
    assert seen(level) > MIN_RELIEF
    assert abs(seen(level, own)) < 0.5 * MIN_RELIEF
