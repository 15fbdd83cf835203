"""What stands in the cell and does not move: table, trays, containers, markers, lights, cameras."""

from math import pi
from typing import Any

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import UNTOUCHED, add_geom, mujoco
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Colour, Layout, Size
from layflat.cell.geometry import about_z, looking
from layflat.cell.markers import board_picture, marker_picture
from layflat.cell.scene.optics import optics_of

TABLE = 0.02  # half its thickness, m
SHEET = 1e-3  # thickness of the board, m
INK = 2e-4  # height of what is printed over its sheet, m: enough to be drawn
BOARD_GROUP = 4  # of geoms: that of the calibration board, which is drawn only while it is held


def furnish(spec: Any, cell: Cell, rng: np.random.Generator) -> None:
    """Add all that stands in the cell to a spec, with lights as this seed has them."""
    world = spec.worldbody
    (x, y), (width, depth) = cell.table.centre, cell.table.size
    _box(world, "table", (width / 2, depth / 2, TABLE), (x, y, -TABLE), cell.table.colour)
    column = cell.mount.height - next(iter(cell.machine.joints.values())).body.height / 2
    size, pos = (0.6 * cell.column_radius, column / 2), [0.0, 0.0, column / 2]
    add_geom(world, "cylinder", "column", size=size, pos=pos, rgba=[0.30, 0.31, 0.33, 1.0])
    for name, tray in cell.tray.items():
        body = _body(world, f"tray.{name}", (*tray.centre, 0.0), tray.rotation)
        _open_box(body, f"tray.{name}", tray.size, tray.height, tray.wall, tray.colour)
    for name, container in cell.container.items():
        key, layout = f"container.{name}", container.layout
        body = _body(world, key, (*container.centre, 0.0), container.rotation)
        inside = (layout.size[0] - 2 * layout.wall, layout.size[1] - 2 * layout.wall)
        _open_box(body, key, inside, layout.height, layout.wall, layout.colour)
        _dividers(body, key, layout)
    thickness = cell.base_markers.thickness
    for name, marker in cell.base_markers.marker.items():
        body = _body(world, f"base_marker.{name}", (*marker.centre, thickness), marker.rotation)
        grey = marker_picture(cell.base_markers.dictionary, marker.number)
        _printed(spec, body, f"base_marker.{name}", grey, (marker.side, marker.side), marker.rim, thickness - INK)
    held = world.add_body(name="board", mocap=True)
    board = cell.board
    _printed(spec, held, "board", board_picture(board), board.size, board.square / 3, SHEET, group=BOARD_GROUP)
    _lights(spec, cell, rng)
    _cameras(spec, cell)


def _body(world: Any, name: str, position: tuple[float, ...], rotation: float) -> Any:
    return world.add_body(name=name, pos=list(position), quat=about_z(rotation).tolist())


def _box(body: Any, name: str, half: tuple[float, ...], at: tuple[float, ...], colour: tuple[float, ...]) -> None:
    add_geom(body, "box", name, size=half, pos=list(at), rgba=[*colour, 1.0], condim=6)


def _open_box(body: Any, name: str, inside: Size, height: float, wall: float, colour: Colour) -> None:
    x, y = inside[0] / 2, inside[1] / 2
    _box(body, f"{name}.floor", (x + wall, y + wall, wall / 2), (0.0, 0.0, wall / 2), colour)
    middle, half = wall + height / 2, height / 2
    for side in (-1, 1):
        _box(body, f"{name}.wall-x{side:+d}", (wall / 2, y + wall, half), (side * (x + wall / 2), 0.0, middle), colour)
        _box(body, f"{name}.wall-y{side:+d}", (x, wall / 2, half), (0.0, side * (y + wall / 2), middle), colour)


def _dividers(body: Any, name: str, layout: Layout) -> None:
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


def _printed(
    spec: Any, body: Any, name: str, grey: Picture, size: Size, margin: float, thick: float, group: int = 0
) -> None:
    """A picture in its body's plane, its first corner at -x, +y, on a sheet with a white margin; lengths in m.

    The margin is part of what is printed: within a texture edges are drawn between pixels, at its end they are not.
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
    sheet: dict[str, Any] = {**UNTOUCHED, "group": group}
    pos, rgba = [0.0, 0.0, -thick / 2 - INK], [0.95, 0.95, 0.95, 1.0]
    add_geom(body, "box", f"{name}.sheet", size=(x, y, thick / 2), pos=pos, rgba=rgba, **sheet)
    printed = spec.add_mesh(
        name=name,
        uservert=[-x, -y, 0, x, -y, 0, x, y, 0, -x, y, 0, 0, 0, -1e-4],
        userface=[0, 1, 2, 0, 2, 3, 0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0],
        usertexcoord=[0, 1, 1, 1, 1, 0, 0, 0, 0, 0],
    )
    add_geom(body, "mesh", f"{name}.print", meshname=printed.name, material=name, **sheet)


def _lights(spec: Any, cell: Cell, rng: np.random.Generator) -> None:
    mj = mujoco()
    ambient = cell.ambient.draw(rng)
    head = spec.visual.headlight
    head.ambient, head.diffuse, head.specular = [ambient] * 3, [0.0] * 3, [0.0] * 3
    sky = {"rgb1": [0.90, 0.92, 0.94], "rgb2": [0.66, 0.70, 0.75], "width": 64, "height": 384}
    spec.add_texture(name="wall", type=mj.mjtTexture.mjTEXTURE_SKYBOX, builtin=mj.mjtBuiltin.mjBUILTIN_GRADIENT, **sky)
    for name, light in cell.light.items():
        at = np.array(light.position) + rng.normal(0.0, light.wander, 3)
        colour = np.clip(light.brightness.draw(rng) * (1.0 + rng.normal(0.0, light.tint, 3)), 0.0, 1.0)
        spec.worldbody.add_light(
            name=name, type=mj.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=light.shadows,
            pos=at.tolist(), dir=(np.array(light.looks_at) - at).tolist(),
            diffuse=colour.tolist(), ambient=[0.0] * 3, specular=(0.4 * colour).tolist(),
        )  # fmt: skip


def _cameras(spec: Any, cell: Cell) -> None:
    optics, over = optics_of(cell.camera), cell.overview
    for name, position, orientation, field in (
        ("camera", cell.camera.position, optics.orientation, optics.field),
        ("overview", over.position, looking(over.position, over.looks_at, 0.0), over.field),
    ):
        spec.worldbody.add_camera(name=name, pos=list(position), quat=list(orientation), fovy=field * 180 / pi)
    spec.visual.global_.offwidth = max(optics.wide[0], over.width)
    spec.visual.global_.offheight = max(optics.wide[1], over.height)
