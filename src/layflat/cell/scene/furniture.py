"""Fixed parts of the cell: table, trays, containers, markers, lights, cameras with their lenses."""

from functools import lru_cache
from math import atan, pi
from typing import Any

import numpy as np

from layflat.arrays import Array, Picture
from layflat.cell.extras import NO_CONTACT, CharucoBoard, add_geom, board_picture, marker_picture, mujoco, opencv
from layflat.cell.file.imaging import Camera
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Colour, ContainerLayout, Size
from layflat.cell.geometry import look_at_orientation, rotation_about_z

TABLE_HALF_THICKNESS = 0.02  # m
SHEET_THICKNESS = 1e-3  # of the calibration board, m
INK_HEIGHT = 2e-4  # of a print over its sheet, m: enough to be rendered
BOARD_GROUP = 4  # geom group of the calibration board, which is rendered only while it is held


class Optics:
    """Geometry of a camera in pinhole form with Brown and Conrady's distortion.

    Matrix (3, 3, px; pixel centres are whole numbers) and distortion are OpenCV's, the orientation is a quaternion of
    MuJoCo: it looks along its -z, x right, y up. The ideal picture is `wide` (px) and `field` high (rad).
    """

    def __init__(self, camera: Camera) -> None:
        """Compute matrix, ideal picture and the lens's map of pixels from a camera's description."""
        f = camera.focal_pixels
        c_x = (camera.width - 1) / 2 + camera.principal_offset[0]
        c_y = (camera.height - 1) / 2 + camera.principal_offset[1]
        self.matrix: Array = np.array([[f, 0.0, c_x], [0.0, f, c_y], [0.0, 0.0, 1.0]])
        bent = camera.distortion
        self.distortion: Array = np.array([bent.k1, bent.k2, bent.p1, bent.p2, bent.k3])
        u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        pixels = np.stack([u, v], axis=-1).reshape(-1, 1, 2).astype(np.float64)
        criteria = (3, 50, 1e-12)  # steps and change at which the search ends
        ideal = opencv().undistortPoints(pixels, self.matrix, self.distortion, criteria=criteria)
        rays = ideal.reshape(camera.height, camera.width, 2)
        half_width, half_height = f * np.abs(rays).max(axis=(0, 1)) + 2.0
        self.wide = (2 * int(np.ceil(half_width)), 2 * int(np.ceil(half_height)))
        self.field = 2.0 * atan(self.wide[1] / 2 / f)
        self.orientation = look_at_orientation(camera.position, camera.looks_at, camera.rotation)
        middle = (np.array(self.wide) - 1.0) / 2.0
        self._from = (f * rays + middle).astype(np.float32)

    def bend(self, ideal: Picture) -> Picture:
        """Return an ideal picture of size `wide` as distorted by the lens, (H, W, 3)."""
        bent: Picture = opencv().remap(ideal, self._from, None, opencv().INTER_LINEAR)
        return bent


camera_optics = lru_cache(maxsize=8)(Optics)  # of a camera's description, cached


def add_furniture(spec: Any, cell: Cell, rng: np.random.Generator) -> None:
    """Add the fixed parts of a cell to a spec: table, trays, containers, markers, board, lights and cameras.

    Args:
        spec: MjSpec.
        cell: description.
        rng: generator of the lights' deviations.
    """
    world = spec.worldbody
    (x, y), (width, depth) = cell.table.centre, cell.table.size
    _box(world, "table", (width / 2, depth / 2, TABLE_HALF_THICKNESS), (x, y, -TABLE_HALF_THICKNESS), cell.table.colour)
    column = cell.mount.height - next(iter(cell.machine.joints.values())).body.height / 2
    size, pos = (0.6 * cell.column_radius, column / 2), [0.0, 0.0, column / 2]
    add_geom(world, "cylinder", "column", size=size, pos=pos, rgba=[0.30, 0.31, 0.33, 1.0])
    for name, tray in cell.tray.items():
        body = _body(world, f"tray.{name}", (*tray.centre, 0.0), tray.rotation)
        _add_open_box(body, f"tray.{name}", tray.size, tray.height, tray.wall, tray.colour)
    for name, container in cell.container.items():
        key, layout = f"container.{name}", container.layout
        body = _body(world, key, (*container.centre, 0.0), container.rotation)
        inside = (layout.size[0] - 2 * layout.wall, layout.size[1] - 2 * layout.wall)
        _add_open_box(body, key, inside, layout.height, layout.wall, layout.colour)
        _add_dividers(body, key, layout)
    thickness = cell.base_markers.thickness
    for name, marker in cell.base_markers.marker.items():
        body = _body(world, f"base_marker.{name}", (*marker.centre, thickness), marker.rotation)
        grey = marker_picture(cell.base_markers.dictionary, marker.number)
        _add_print(
            spec, body, f"base_marker.{name}", grey, (marker.side, marker.side), marker.rim, thickness - INK_HEIGHT
        )
    held = world.add_body(name="board", mocap=True)
    board = cell.board
    _add_print(
        spec,
        held,
        "board",
        board_picture(CharucoBoard(**board.model_dump())),
        board.size,
        board.square / 3,
        SHEET_THICKNESS,
        group=BOARD_GROUP,
    )
    _add_lights(spec, cell, rng)
    _add_cameras(spec, cell)


def _body(world: Any, name: str, position: tuple[float, ...], rotation: float) -> Any:
    return world.add_body(name=name, pos=list(position), quat=rotation_about_z(rotation).tolist())


def _box(body: Any, name: str, half: tuple[float, ...], at: tuple[float, ...], colour: tuple[float, ...]) -> None:
    add_geom(body, "box", name, size=half, pos=list(at), rgba=[*colour, 1.0], condim=6)


def _add_open_box(body: Any, name: str, inside: Size, height: float, wall: float, colour: Colour) -> None:
    """Add the boxes of an open box to a body: a floor and four walls outside of the inner size; m."""
    x, y = inside[0] / 2, inside[1] / 2
    _box(body, f"{name}.floor", (x + wall, y + wall, wall / 2), (0.0, 0.0, wall / 2), colour)
    middle, half = wall + height / 2, height / 2
    for side in (-1, 1):
        _box(body, f"{name}.wall-x{side:+d}", (wall / 2, y + wall, half), (side * (x + wall / 2), 0.0, middle), colour)
        _box(body, f"{name}.wall-y{side:+d}", (x, wall / 2, half), (0.0, side * (y + wall / 2), middle), colour)


def _add_dividers(body: Any, name: str, layout: ContainerLayout) -> None:
    """Add the dividers between the columns and rows of a container, if its layout has some."""
    if layout.divider == 0.0:
        return
    x, y = layout.size[0] / 2 - layout.wall, layout.size[1] / 2 - layout.wall
    lighter = tuple(min(1.0, 1.15 * channel) for channel in layout.colour)
    middle, half, thin = layout.wall + layout.divider / 2, layout.divider / 2, layout.wall / 2
    for i in range(1, layout.columns):
        at = (i - layout.columns / 2) * layout.pitch[0]
        _box(body, f"{name}.across-{i}", (thin, y, half), (at, 0.0, middle), lighter)
    for i in range(1, layout.rows):
        at = (i - layout.rows / 2) * layout.pitch[1]
        _box(body, f"{name}.along-{i}", (x, thin, half), (0.0, at, middle), lighter)


def _add_print(
    spec: Any, body: Any, name: str, grey: Picture, size: Size, margin: float, thick: float, group: int = 0
) -> None:
    """Add a picture in a body's plane, its first corner at -x, +y, on a sheet with a white margin; lengths in m.

    The margin is part of the print: edges within a texture are rendered between pixels, those at its end are not.
    """
    mj = mujoco()
    rim = round(margin / size[0] * grey.shape[1])
    grey = np.pad(grey, rim, constant_values=255)
    size_px = {"height": grey.shape[0], "width": grey.shape[1]}
    texture = spec.add_texture(name=name, type=mj.mjtTexture.mjTEXTURE_2D, nchannel=3, **size_px)
    texture.data = np.repeat(grey[:, :, None], 3, axis=2).tobytes()
    material = spec.add_material(name=name, specular=0.0, shininess=0.0)
    material.textures[mj.mjtTextureRole.mjTEXROLE_RGB] = name
    margin = rim * size[0] / (grey.shape[1] - 2 * rim)
    x, y = size[0] / 2 + margin, size[1] / 2 + margin
    sheet: dict[str, Any] = {**NO_CONTACT, "group": group}
    pos, rgba = [0.0, 0.0, -thick / 2 - INK_HEIGHT], [0.95, 0.95, 0.95, 1.0]
    add_geom(body, "box", f"{name}.sheet", size=(x, y, thick / 2), pos=pos, rgba=rgba, **sheet)
    printed = spec.add_mesh(
        name=name,
        uservert=[-x, -y, 0, x, -y, 0, x, y, 0, -x, y, 0, 0, 0, -1e-4],
        userface=[0, 1, 2, 0, 2, 3, 0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0],
        usertexcoord=[0, 1, 1, 1, 1, 0, 0, 0, 0, 0],
    )
    add_geom(body, "mesh", f"{name}.print", meshname=printed.name, material=name, **sheet)


def _add_lights(spec: Any, cell: Cell, rng: np.random.Generator) -> None:
    """Add ambient light, sky and directional lights, each randomly varied in brightness, tint and position."""
    mj = mujoco()
    ambient = cell.ambient.draw(rng)
    head = spec.visual.headlight
    head.ambient, head.diffuse, head.specular = [ambient] * 3, [0.0] * 3, [0.0] * 3
    sky = {"rgb1": [0.90, 0.92, 0.94], "rgb2": [0.66, 0.70, 0.75], "width": 64, "height": 384}
    spec.add_texture(name="wall", type=mj.mjtTexture.mjTEXTURE_SKYBOX, builtin=mj.mjtBuiltin.mjBUILTIN_GRADIENT, **sky)
    for name, light in cell.light.items():
        at = np.array(light.position) + rng.normal(0.0, light.position_std, 3)
        colour = np.clip(light.brightness.draw(rng) * (1.0 + rng.normal(0.0, light.colour_std, 3)), 0.0, 1.0)
        spec.worldbody.add_light(
            name=name, type=mj.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=light.shadows,
            pos=at.tolist(), dir=(np.array(light.looks_at) - at).tolist(),
            diffuse=colour.tolist(), ambient=[0.0] * 3, specular=(0.4 * colour).tolist(),
        )  # fmt: skip


def _add_cameras(spec: Any, cell: Cell) -> None:
    """Add the cell's camera and the overview, and enlarge the renderer to the larger picture."""
    optics, over = camera_optics(cell.camera), cell.overview
    for name, position, orientation, field in (
        ("camera", cell.camera.position, optics.orientation, optics.field),
        ("overview", over.position, look_at_orientation(over.position, over.looks_at, 0.0), over.field_of_view),
    ):
        spec.worldbody.add_camera(name=name, pos=list(position), quat=list(orientation), fovy=field * 180 / pi)
    spec.visual.global_.offwidth = max(optics.wide[0], over.width)
    spec.visual.global_.offheight = max(optics.wide[1], over.height)
