"""Random scenes with known truth, the boards and markers that calibrate their camera, and the kinds of produce."""

from __future__ import annotations

import colorsys
from dataclasses import replace
from functools import cache

import numpy as np

from layflat.cell.extras import make_charuco_board
from layflat.cell.vision import BaseMarkers, Calibration, CharucoBoard, Colour, Marker, ProduceKind, calibrate
from tests.cell.vision.pictures import Ball, Flat, Light, Plate, Scene, TrueCamera, marker_plate, take

CAMERA = TrueCamera()
TABLE = (60.0, 95.0, 140.0)
TRAY = (30.0, 50.0, 80.0)
PACK = (95.0, 130.0, 150.0)
BACKGROUND = (Colour(hue=(190, 240), saturation=(0.22, 1.0)), Colour(value=(0.0, 0.12)))
KINDS = (
    ProduceKind("tomato", (Colour((345, 38), (0.5, 1.0), (0.12, 1.0)),), (0.045, 0.075)),
    ProduceKind("apple", (Colour((55, 125), (0.3, 1.0), (0.12, 1.0)),), (0.06, 0.085)),
    ProduceKind(
        "mushroom",
        (Colour((15, 80), (0.0, 0.35), (0.2, 1.0)), Colour((0, 360), (0.0, 0.12), (0.45, 1.0))),
        (0.03, 0.055),
    ),
)
MARKERS = BaseMarkers(
    (
        Marker(0, 0.06, 0.27, 0.05),
        Marker(1, 0.78, 0.27, 0.05, yaw=0.3),
        Marker(2, 0.06, -0.21, 0.05, yaw=-0.2),
        Marker(3, 0.78, -0.21, 0.05),
    )
)
PLATES = tuple(marker_plate(m.number, m.x, m.y, m.side, m.yaw) for m in MARKERS.markers)
BOARD = CharucoBoard(9, 7, 0.03, 0.022, "DICT_5X5_100")


def skin(rng: np.random.Generator, kind: str | None) -> tuple[float, float, float]:
    """A random colour of a kind, RGB of 255."""
    hue, saturation, value = {
        "tomato": (rng.uniform(-5, 30), rng.uniform(0.78, 0.92), rng.uniform(0.6, 0.9)),
        "apple": (rng.uniform(65, 110), rng.uniform(0.55, 0.75), rng.uniform(0.6, 0.85)),
        "mushroom": (rng.uniform(32, 45), rng.uniform(0.12, 0.18), rng.uniform(0.75, 0.9)),
        None: (rng.uniform(280, 320), rng.uniform(0.5, 0.8), rng.uniform(0.4, 0.8)),
    }[kind]
    return tuple(255 * part for part in colorsys.hsv_to_rgb((hue % 360) / 360, saturation, value))  # type: ignore[return-value]


def ball(rng: np.random.Generator, kind: str | None, x: float, y: float) -> Ball:
    limits = {"tomato": (0.048, 0.072), "apple": (0.063, 0.082), "mushroom": (0.032, 0.052), None: (0.05, 0.07)}
    spot = (40.0, 95.0, 30.0) if kind == "tomato" and rng.random() < 0.6 else None
    return Ball(kind or "", x, y, rng.uniform(*limits[kind]) / 2, skin(rng, kind), spot, rng.uniform(0.0, 0.35))


def random_scene(seed: int) -> Scene:
    """Ten to twenty fruit, half of them touching another, clutter, one unknown fruit at times, light of all sorts."""
    rng = np.random.default_rng(seed)
    balls: list[Ball] = []
    wanted = rng.integers(10, 21)
    for _ in range(400):
        if len(balls) >= wanted:
            break
        kind = rng.choice(["tomato", "apple", "mushroom"])
        new = ball(rng, str(kind), rng.uniform(0.1, 0.74), rng.uniform(-0.19, 0.25))
        if balls and rng.random() < 0.6:
            old = balls[rng.integers(len(balls))]
            if rng.random() < 0.7:
                new = replace(ball(rng, old.kind, 0, 0), colour=skin(rng, old.kind))
            turn, gap = rng.uniform(0, 2 * np.pi), 2 * np.sqrt(old.radius * new.radius) * 1.002
            new = replace(new, x=old.x + gap * np.cos(turn), y=old.y + gap * np.sin(turn))
        if free(new, balls):
            balls.append(new)
    if rng.random() < 0.5:
        for _ in range(50):
            new = ball(rng, None, rng.uniform(0.15, 0.7), rng.uniform(-0.15, 0.2))
            if free(new, balls, 0.005):
                balls.append(new)
                break
    return Scene(
        balls=balls,
        flats=(Flat(0.3, 0.05, 0.36, 0.3, TRAY), Flat(0.63, 0.02, 0.2, 0.3, PACK), *clutter(rng, balls)),
        plates=PLATES,
        table=TABLE,
        lights=tuple(
            Light((rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6), 1.0), rng.uniform(0.08, 0.25)) for _ in range(3)
        ),
        ambient=rng.uniform(0.25, 0.4),
        tint=tuple(rng.uniform(0.92, 1.08, 3)),
        slope=tuple(rng.uniform(-0.35, 0.35, 2)),
    )


def free(new: Ball, balls: list[Ball], gap: float = 0.0) -> bool:
    """Whether a ball is on the table, off the markers and in no other."""
    if not (0.09 < new.x < 0.75 and -0.2 < new.y < 0.26):
        return False
    if any(np.hypot(new.x - m.x, new.y - m.y) < new.radius + 0.055 for m in MARKERS.markers):
        return False
    return all(np.linalg.norm(new.centre - old.centre) >= new.radius + old.radius + gap for old in balls)


def clutter(rng: np.random.Generator, balls: list[Ball]) -> list[Flat]:
    """Leaves, labels, lids, tools and fingers that lie clear of fruit."""
    makers = (
        lambda x, y: Flat(x, y, 0.07, 0.035, (50, 120, 40), rng.uniform(0, 3), oval=True),  # leaf
        lambda x, y: Flat(x, y, 0.06, 0.04, (225, 225, 220), rng.uniform(0, 3)),  # label
        lambda x, y: Flat(x, y, 0.055, 0.055, (200, 30, 25), rng.uniform(0, 3)),  # red square
        lambda x, y: Flat(x, y, 0.06, 0.06, (200, 40, 30), oval=True),  # red lid
        lambda x, y: Flat(x, y, 0.16, 0.02, (130, 130, 130), rng.uniform(0, 3)),  # tool
        lambda x, y: Flat(x, y, 0.1, 0.022, (205, 150, 120), rng.uniform(0, 3)),  # finger
        lambda x, y: Flat(x, y, 0.02, 0.02, (200, 30, 25), oval=True),  # berry, too small
    )
    made: list[Flat] = []
    for number in rng.choice(len(makers), rng.integers(2, 7)):
        for _ in range(30):
            new = makers[number](rng.uniform(0.12, 0.72), rng.uniform(-0.16, 0.22))
            reach = np.hypot(new.long, new.wide) / 2
            if all(np.hypot(new.x - b.x, new.y - b.y) > reach + b.radius * 1.3 + 0.004 for b in balls) and all(
                np.hypot(new.x - f.x, new.y - f.y) > reach + np.hypot(f.long, f.wide) / 2 for f in made
            ):
                made.append(new)
                break
    return made


def board_plate(board: CharucoBoard, middle: tuple[float, float, float], tilt: tuple[float, float, float]) -> Plate:
    """A ChArUco board in the air, its face to the camera."""
    texture = make_charuco_board(board).generateImage((board.columns * 100, board.rows * 100))
    texture = np.pad(texture, 50, constant_values=255)
    turn = replace(CAMERA, tilt=tilt).rotation.T
    right = turn[:, 0] * board.square * (board.columns + 1)
    down = turn[:, 1] * board.square * (board.rows + 1)
    return Plate(texture, np.array(middle) - (right + down) / 2, right, down)


def board_scenes(count: int = 9, seed: int = 1) -> list[Scene]:
    rng = np.random.default_rng(seed)
    spots = [
        (0.42 + 0.2 * np.cos(a), 0.03 + 0.13 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, count, endpoint=False)
    ]
    scenes = []
    for x, y in spots:
        tilt = (rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6), rng.uniform(-0.4, 0.4))
        scenes.append(Scene(plates=(board_plate(BOARD, (x, y, rng.uniform(0.12, 0.3)), tilt),), table=TABLE))
    return scenes


@cache
def calibrated() -> Calibration:
    """The camera's calibration, from pictures alone."""
    views = [take(scene, CAMERA, seed) for seed, scene in enumerate(board_scenes())]
    return calibrate(views, BOARD, take(Scene(plates=PLATES, table=TABLE), CAMERA, 99), MARKERS)


@cache
def true_calibration() -> Calibration:
    """What a perfect calibration would say."""
    R = CAMERA.rotation
    (fx, fy), (cx, cy) = CAMERA.focal, CAMERA.middle
    return Calibration(
        picture_px=CAMERA.size,
        camera_matrix_px=((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)),
        distortion=CAMERA.distortion,
        rotation=R.tolist(),
        translation_m=tuple((-R @ np.array(CAMERA.position)).tolist()),
        lens_error_px=0.0,
        pose_error_px=0.0,
    )
