"""The camera of a scene calibrated as one on a rig is: a board held before it, then the markers on the table."""

from collections.abc import Callable
from math import cos, pi, sin

import numpy as np

from layflat.arrays import Array
from layflat.cell.file.model import Cell
from layflat.cell.geometry import product, rotated
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.scene.optics import optics_of
from layflat.cell.vision import BaseMarkers, Calibration, CharucoBoard, Marker, calibrate

# Where the board is held: in the middle of the picture, then around it.
SPOTS = ((0, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0))
TILT = 0.5  # of the board from facing the camera, rad, to another side in each view
FILLS = 0.42  # share of the picture that the board fills


def calibrate_scene(
    scene: Scene, camera: SimulatedCamera, progress: Callable[[float], object] = lambda _: None
) -> Calibration:
    """Calibrate with the cell's board in nine poses before the camera, then with the markers on the table.

    The arm of the scene is out of the camera's view; `progress` is called with the share that is done. Raise
    PictureError if a picture is dark or blurred, CameraError if board or markers are not detected.
    """
    poses, pictures = views_of(scene.cell), []
    for number, (position, orientation) in enumerate(poses, start=1):
        scene.hold_board(position, orientation)
        pictures.append(camera.picture())
        progress(number / (len(poses) + 2))
    scene.board_held = False
    board = CharucoBoard(**scene.cell.board.model_dump())
    calibration = calibrate(pictures, board, camera.picture(), base_of(scene.cell))
    progress(1.0)
    return calibration


def base_of(cell: Cell) -> BaseMarkers:
    """Return the markers that lie on the table."""
    base = cell.base_markers
    lying = (Marker(m.number, *m.centre, m.side, m.rotation, base.thickness) for m in base.marker.values())
    return BaseMarkers(tuple(lying), base.dictionary)


def views_of(cell: Cell) -> list[tuple[Array, Array]]:
    """Return poses of the board, tilted and in all parts of the picture: middle (3,), m, and quaternion, w first."""
    camera, facing = cell.camera, np.array(optics_of(cell.camera).orientation)
    wide, high = cell.board.size
    away = camera.focal_pixels * max(wide / (FILLS * camera.width), high / (FILLS * camera.height))
    # At the picture's edges the whole board is still in view.
    reach = 0.5 * (0.96 - FILLS) * np.array([camera.width, camera.height]) / camera.focal_pixels
    poses = []
    for number, (right, up) in enumerate(SPOTS):
        before = away * np.array([right * reach[0], up * reach[1], -1.0])
        way = 2.0 * pi * number * 3 / len(SPOTS) + 0.4 * number
        tilted = np.array([cos(TILT / 2), sin(TILT / 2) * cos(way), sin(TILT / 2) * sin(way), 0.0])
        poses.append((np.array(camera.position) + rotated(facing, before), product(facing, tilted)))
    return poses
