from __future__ import annotations

import colorsys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from layflat.cell.vision import SURE_CONFIDENCE, Colour, ColourDetector, Detection, ProduceKind
from layflat.errors import InputError, PictureError
from tests.cell.vision.pictures import Ball, Flat, Light, Picture, Scene, take
from tests.cell.vision.vision_scenes import (
    BACKGROUND,
    CAMERA,
    KINDS,
    PLATES,
    TABLE,
    TRAY,
    random_scene,
    true_calibration,
)

RED, GREEN, CREAM, PURPLE = (190.0, 40.0, 30.0), (120.0, 170.0, 60.0), (215.0, 205.0, 185.0), (120.0, 40.0, 140.0)
DETECTOR = ColourDetector(KINDS, TABLE, BACKGROUND)


def hue(one: Detection) -> float:
    red, green, blue = one.colour
    return 360.0 * colorsys.rgb_to_hsv(red / 255.0, green / 255.0, blue / 255.0)[0]


def scene(*balls: Ball, **more: Any) -> Scene:
    return replace(Scene(balls=balls, plates=PLATES, table=TABLE), **more)


def found_in(seen: Scene, seed: int = 3) -> list[Detection]:
    return DETECTOR.detect(take(seen, CAMERA, seed), true_calibration())


def nearest(found: list[Detection], ball: Ball) -> Detection:
    return min(found, key=lambda one: float(np.hypot(one.position[0] - ball.x, one.position[1] - ball.y)))


@pytest.mark.parametrize("seed", [4, 7, 45])
def test_random_scenes_are_seen_rightly(seed: int) -> None:
    """Touching fruit, clutter, tinted and uneven light: each fruit once, exactly, and nothing else."""
    drawn = random_scene(seed)
    found = [one for one in found_in(drawn, seed) if one.kind and one.confidence >= SURE_CONFIDENCE]
    fruit = [ball for ball in drawn.balls if ball.kind]
    assert len(found) == len(fruit)
    for ball in fruit:
        one = nearest(found, ball)
        assert one.kind == ball.kind
        assert one.position == pytest.approx(ball.centre, abs=1e-3)
        assert one.diameter == pytest.approx(2 * ball.radius, rel=0.03)


def test_clutter_is_no_produce() -> None:
    flats = (
        Flat(0.2, 0.1, 0.055, 0.055, RED),
        Flat(0.32, 0.1, 0.06, 0.06, RED, oval=True),
        Flat(0.45, 0.1, 0.07, 0.045, GREEN, yaw=0.5, oval=True),
        Flat(0.58, 0.1, 0.05, 0.035, CREAM),
        Flat(0.3, -0.1, 0.12, 0.022, (205.0, 150.0, 120.0)),
        Flat(0.55, -0.1, 0.02, 0.02, RED, oval=True),
    )
    assert found_in(scene(flats=flats)) == []


def test_an_empty_table_has_nothing() -> None:
    assert found_in(scene()) == []


def test_four_in_a_square_are_four() -> None:
    r = 0.027
    balls = [Ball("tomato", 0.4 + i * r, 0.05 + j * r, r, RED) for i in (-1, 1) for j in (-1, 1)]
    found = found_in(scene(*balls))
    assert len(found) == 4
    for ball in balls:
        assert nearest(found, ball).position == pytest.approx(ball.centre, abs=1e-3)


def test_nothing_is_seen_between_three_that_touch() -> None:
    """The notches of three make a circle too."""
    r = 0.021
    turn = np.deg2rad([90.0, 210.0, 330.0])
    balls = [
        Ball("mushroom", 0.5 + 2 * r / np.sqrt(3) * np.cos(a), 0.05 + 2 * r / np.sqrt(3) * np.sin(a), r, CREAM)
        for a in turn
    ]
    found = found_in(scene(*balls))
    assert len(found) == 3
    for ball in balls:
        assert nearest(found, ball).position == pytest.approx(ball.centre, abs=1e-3)


def test_fruit_of_an_unknown_kind_is_told_as_none() -> None:
    (one,) = found_in(scene(Ball("", 0.3, 0.1, 0.03, PURPLE)))
    assert one.kind is None
    assert one.position == pytest.approx((0.3, 0.1, 0.03), abs=1e-3)


def test_without_background_nothing_unknown_is_told() -> None:
    picture = take(scene(Ball("", 0.3, 0.1, 0.03, PURPLE)), CAMERA, 3)
    assert ColourDetector(KINDS, TABLE).detect(picture, true_calibration()) == []


def test_fruit_of_another_size_is_no_produce() -> None:
    assert not any(one.kind for one in found_in(scene(Ball("", 0.4, 0.0, 0.055, RED))))
    assert not any(one.kind for one in found_in(scene(Ball("", 0.4, 0.0, 0.015, RED))))


@pytest.mark.parametrize(
    ("hidden", "least", "most"), [(0.1, SURE_CONFIDENCE, 1.0), (0.45, 0.0, SURE_CONFIDENCE), (0.7, 0.0, 0.0)]
)
def test_what_is_hidden_is_less_sure(hidden: float, least: float, most: float) -> None:
    ball = Ball("tomato", 0.4, 0.05, 0.03, RED)
    edge = ball.x + ball.radius - hidden * 2 * ball.radius
    arm = Flat(edge + 0.05, 0.05, 0.1, 0.3, (40.0, 40.0, 42.0))
    found = found_in(scene(ball, covers=(arm,)))
    assert max((one.confidence for one in found if one.kind), default=0.0) <= most
    assert max((one.confidence for one in found if one.kind), default=0.0) >= least


@pytest.mark.parametrize(
    ("light", "tint", "slope"),
    [(0.6, (1.0, 1.0, 1.0), (0.0, 0.0)), (1.3, (1.08, 1.0, 0.92), (0.0, 0.0)), (1.0, (0.93, 1.0, 1.08), (0.4, -0.4))],
)
def test_light_changes_neither_hue_nor_place(light: float, tint: tuple[float, ...], slope: tuple[float, float]) -> None:
    balls = (
        Ball("tomato", 0.2, 0.1, 0.03, (180.0, 36.0, 30.0)),
        Ball("tomato", 0.3, 0.1, 0.03, (190.0, 95.0, 30.0)),
        Ball("apple", 0.5, -0.05, 0.035, (165.0, 170.0, 60.0)),
        Ball("apple", 0.6, 0.1, 0.035, (75.0, 160.0, 60.0)),
    )
    lit = scene(*balls, ambient=0.45 * light, lights=(Light((0.3, 0.2, 1.0), 0.5 * light),), tint=tint, slope=slope)
    found = found_in(lit)
    for ball, (start, end) in zip(balls, ((-15, 14), (14, 38), (55, 85), (85, 125)), strict=True):
        one = nearest(found, ball)
        assert start < (hue(one) + 180.0) % 360.0 - 180.0 < end
        assert one.position == pytest.approx(ball.centre, abs=1e-3)


def test_stalk_and_shine_do_not_change_the_hue() -> None:
    plain, odd = (Ball("tomato", 0.3, 0.1, 0.03, (190.0, 70.0, 30.0), spot, shine) for spot, shine in
                  ((None, 0.0), ((40.0, 95.0, 30.0), 0.35)))  # fmt: skip
    assert hue(found_in(scene(odd))[0]) == pytest.approx(hue(found_in(scene(plain))[0]), abs=2.0)


def test_a_flatter_kind_has_its_middle_lower() -> None:
    flat = replace(KINDS[0], height_ratio=0.8)
    picture = take(scene(Ball("tomato", 0.3, 0.1, 0.03, RED)), CAMERA, 3)
    (one,) = ColourDetector([flat], TABLE).detect(picture, true_calibration())
    assert one.position[2] == pytest.approx(0.8 * one.diameter / 2)
    assert one.diameter == pytest.approx(0.06, rel=0.02)


def test_produce_on_a_floor_over_the_table() -> None:
    picture = take(scene(Ball("tomato", 0.7, 0.1, 0.03, RED, floor=0.02)), CAMERA, 3)
    (one,) = ColourDetector(KINDS, TABLE, plane=0.02).detect(picture, true_calibration())
    assert one.position == pytest.approx((0.7, 0.1, 0.05), abs=1e-3)
    assert one.diameter == pytest.approx(0.06, rel=0.02)
    (wrong,) = ColourDetector(KINDS, TABLE).detect(picture, true_calibration())
    assert abs(wrong.position[0] - 0.7) > 3e-3


def test_the_same_picture_gives_the_same_detections() -> None:
    picture = take(random_scene(5), CAMERA, 5)
    first, second = (DETECTOR.detect(picture, true_calibration()) for _ in range(2))
    assert [one.position for one in first] == [one.position for one in second]


@pytest.mark.parametrize(
    ("spoilt", "told"),
    [
        (np.zeros_like, "is black: mean level 0 of 255"),
        (lambda picture: np.full_like(picture, 255), "is white"),
        (lambda picture: picture[:-1], "is 1280 x 959 px; give 1280 x 960 px"),
        (lambda picture: picture[..., 0], "give uint8"),
        (lambda picture: picture.astype(float), "give uint8"),
        (lambda picture: np.full_like(picture, 128), "has no edges"),
        (lambda picture: picture[..., ::-1].copy(), "shows no table"),
    ],
)
def test_pictures_that_cannot_be_used_are_refused(spoilt: Any, told: str) -> None:
    picture: Picture = take(
        scene(Ball("tomato", 0.3, 0.1, 0.03, RED), flats=(Flat(0.6, 0.0, 0.2, 0.2, TRAY),)), CAMERA, 3
    )
    with pytest.raises(PictureError, match=told):
        DETECTOR.detect(spoilt(picture), true_calibration())


@pytest.mark.parametrize("noise", [0.5, 5.0])
def test_blur_is_refused_however_noisy_and_dark(noise: float) -> None:
    for light in (0.4, 1.0):
        lit = scene(ambient=light, lights=())
        assert found_in(lit) == []
        with pytest.raises(PictureError, match="blurred"):
            DETECTOR.detect(take(lit, CAMERA, 1, noise=noise, blur=4.0), true_calibration())


def test_motion_blur_is_refused() -> None:
    import cv2

    picture: Any = cv2.blur(take(scene(), CAMERA, 1), (15, 1))
    with pytest.raises(PictureError, match="blurred"):
        DETECTOR.detect(picture, true_calibration())


def test_kinds_must_make_sense() -> None:
    with pytest.raises(InputError, match="each with its own name"):
        ColourDetector([KINDS[0], KINDS[0]], TABLE)
    with pytest.raises(InputError, match="give the least, then the greatest"):
        ProduceKind("plum", (Colour(),), (0.05, 0.04))
