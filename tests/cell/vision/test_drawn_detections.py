from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from layflat.cell.vision import Detection, draw_detections

TURN = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
SEEN = Detection(
    kind="tomato",
    position=(0.3, 0.1, 0.03),
    diameter=0.06,
    colour=(190.0, 40.0, 30.0),
    confidence=0.95,
    outline=np.column_stack([150.0 + 60.0 * np.cos(TURN), 120.0 + 60.0 * np.sin(TURN)]),
)


@pytest.mark.parametrize("level", [0, 128, 255])
def test_drawn_in_black_and_white_on_any_ground(level: int) -> None:
    ground = np.full((240, 300, 3), level, np.uint8)
    drawn = draw_detections(ground, [SEEN])
    assert (ground == level).all()
    changed = np.abs(drawn.astype(int) - level).max(axis=2)
    assert (drawn == drawn[..., :1]).all()
    assert changed.max() > 120
    away = np.hypot(*(np.indices((240, 300))[::-1] - np.array([150, 120])[:, None, None]))
    assert (changed[(away > 58) & (away < 62)] > 30).mean() > 0.5
    assert not changed[away > 65].any()
    assert changed[away < 50].any()


def test_unsure_ones_are_dashed() -> None:
    ground = np.full((240, 300, 3), 128, np.uint8)
    sure, unsure = (
        np.count_nonzero(draw_detections(ground, [replace(SEEN, confidence=c)])[:, :, 0] != 128) for c in (0.95, 0.15)
    )
    assert unsure < 0.85 * sure


def test_what_is_unknown_is_drawn_too() -> None:
    ground = np.full((240, 300, 3), 128, np.uint8)
    assert (draw_detections(ground, [replace(SEEN, kind=None)]) != draw_detections(ground, [SEEN])).any()


@pytest.mark.parametrize("level", [40, 245])
def test_text_is_bright_on_dark_ground_and_dark_on_bright_ground(level: int) -> None:
    ground = np.full((240, 300, 3), level, np.uint8)
    text = draw_detections(ground, [SEEN])[100:140, 110:190].astype(int)
    assert np.count_nonzero(np.abs(text - level) > 150) > 100  # strokes of letters, inside their rims
