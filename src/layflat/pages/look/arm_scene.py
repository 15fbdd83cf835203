"""An arm in three dimensions on a page: as it is, where it is to go, the way of its tip, and where the tip may go."""

from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from nicegui import app, events, ui
from nicegui.elements.scene.scene_object3d import Object3D
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.bridge.meshes import solid
from layflat.bridge.pieces import Piece
from layflat.bridge.view.scenery import FIELD, scenery, viewpoint
from layflat.machine import Machine
from layflat.pages.look.sparing import Sparing

COLOURS = {"link": "#aab4c0", "joint": "#29333f", "tip": "#c05a00"}  # far apart in black and white, too
FRAMES = 10  # a second, at most, where something changes: a browser without a graphics device draws them by itself
GHOST = "#1b6a8f"
WITHIN = 0.97  # a target is drawn so much smaller: where the arm is there, it hides it
VISIBLE = 1e-3  # what moves less is not drawn anew, rad: a sensor's noise
TRAIL, TRAIL_STEP = 400, 0.002  # points of the tip's way that are shown, and how far they are apart, m
ABOVE = 0.002  # the floor lies what is drawn on it, m
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # cylinders there lie along y, here along z
DOT = (
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC"
)
"""A picture of one white point, of which coloured surfaces are made."""


class ArmScene:
    """The scene of a machine's arm.

    Args:
        machine: whose arm it is.
        label: what it shows, for a reader of screens.
        clicked: told where the reachable surface was clicked, in the frame of the base, m, (3,).
        height: as in CSS.
    """

    def __init__(
        self, machine: Machine, *, label: str, clicked: Callable[[Array], object] | None = None, height: str = "20rem"
    ) -> None:
        rest = [0.0] * len(machine.joints)
        self._shown, self._clicked = scenery(machine, rest), clicked
        self.scene = ui.scene(
            grid=False, background_color="#eef1f4", fps=FRAMES, on_click=self._click, click_events=["click"],
            camera=ui.scene.perspective_camera(fov=FIELD, near=0.05, far=30),
        ).classes("w-full")  # fmt: skip
        self.scene.style(f"height: {height}").props(f'role=img aria-label="{label}"')
        Sparing(self.scene)
        self._trail: deque[list[float]] = deque(maxlen=TRAIL)
        self._posed = np.full(len(rest), np.inf)
        with self.scene as scene:
            self._floor()
            self._arm = self._build(None)
            self._ghost = self._build(GHOST)
            self._way = scene.point_cloud([], point_size=0.012).material("#c05a00")
            self._reach: Object3D | None = None
        self.target(None)
        self.pose(rest)
        eye = viewpoint(self._shown.placed(rest), self._shown.floor, 1.5)
        (x, y, z), (to_x, to_y, to_z) = eye.place.tolist(), eye.centre.tolist()
        self.scene.move_camera(x, y, z, to_x, to_y, to_z, 0.0, 0.0, 1.0, duration=0.0)

    def pose(self, angles: Sequence[float] | Array) -> None:
        """Put the arm where its joints are, rad, and its tip's way behind it."""
        if float(np.abs(angles - self._posed).max()) < VISIBLE:
            return
        self._posed = np.array(angles, float)
        self._place(self._arm, angles)
        tip = self._shown.level @ self._shown.tip(angles)
        if not self._trail or float(np.abs(tip - self._trail[-1]).max()) > TRAIL_STEP:
            self._trail.append(tip.tolist())
            self._way.set_points(list(self._trail))

    def target(self, angles: Sequence[float] | Array | None) -> None:
        """Show where the joints are to go, rad; None: nowhere."""
        for group in self._ghost:
            group.visible(angles is not None)
        if angles is not None:
            self._place(self._ghost, angles)

    def reachable(self, corners: Array, there: NDArray[np.bool_], *, on_floor: bool = False) -> None:
        """Show a surface of places that the tip comes to.

        Args:
            corners: a grid of places in the frame of the base, m, (rows, columns, 3).
            there: which of them the tip comes to, (rows, columns).
            on_floor: whether their picture on the floor is shown in place of them.
        """
        rooms = corners @ self._shown.level.T
        if on_floor:
            rooms[..., 2] = self._shown.floor + ABOVE
        grid = [
            [at if ok else None for at, ok in zip(*row, strict=True)] for row in zip(rooms.tolist(), there, strict=True)
        ]
        if self._reach is not None:
            self._reach.delete()
        with self.scene as scene:
            self._reach = scene.texture(DOT, grid).material("#2f7a2a", 0.25, "both").with_name("reach")

    def _click(self, event: events.SceneClickEventArguments) -> None:
        hits = [hit for hit in event.hits if hit.object_name == "reach"]
        if hits and self._clicked is not None:
            self._clicked(self._shown.level.T @ np.array([hits[0].x, hits[0].y, hits[0].z]))

    def _floor(self) -> None:
        scene, floor = self.scene, self._shown.floor
        for at in np.arange(-1.0, 1.01, 0.1).round(3).tolist():
            for start, end in (([at, -1.0, floor], [at, 1.0, floor]), ([-1.0, at, floor], [1.0, at, floor])):
                scene.line(start, end).material("#c3cad2" if at else "#8b95a1")

    def _build(self, ghost: str | None) -> list[Object3D]:
        """Return the groups of all frames, with what is drawn in each."""
        groups: list[Object3D] = []
        for frame in range(len(self._shown.arm.links) + 2):
            with self.scene.group() as group:
                for place, piece in self._shown.pieces:
                    if place == frame and not (ghost and frame == 0):
                        _draw(self.scene, piece, ghost)
            groups.append(group)
        return groups

    def _place(self, groups: Sequence[Object3D], angles: Sequence[float] | Array) -> None:
        for group, (axes, origin) in zip(groups, self._shown.frames(angles), strict=True):
            group.move(*origin.round(4).tolist())
            group.rotate_R(axes.round(5).tolist())


def _draw(scene: ui.scene, piece: Piece, ghost: str | None) -> None:
    for made, axes, along in _solids(scene, piece):
        place = piece.place + piece.axes @ np.array([0.0, 0.0, along])
        made.material(ghost or COLOURS[piece.of], 0.35 if ghost else 1.0)
        if ghost:
            made.scale(WITHIN)
        made.move(*place.tolist()).rotate_R((piece.axes @ axes).tolist())


def _solids(scene: ui.scene, piece: Piece) -> list[tuple[Object3D, Array, float]]:
    """Return what a piece is made of: each with its axes in the piece, and how far along its z it is, m."""
    size, straight = piece.size, np.eye(3)
    if piece.kind == "box":
        width, height, depth = size
        return [(scene.box(width, height, depth), straight, 0.0)]
    if piece.kind == "sphere":
        return [(scene.sphere(0.5 * size[0], 16, 12), straight, 0.0)]
    if piece.kind == "mesh":
        return [(scene.stl(_served(piece)), straight, 0.0)]
    radius, length = 0.5 * size[0], size[1]
    found: list[tuple[Object3D, Array, float]] = [(scene.cylinder(radius, radius, length, 24), UPRIGHT, 0.0)]
    if piece.kind == "capsule":
        found += [(scene.sphere(radius, 16, 12), straight, end * 0.5 * length) for end in (-1.0, 1.0)]
    return found


_meshes: dict[tuple[Path, tuple[float, ...]], str] = {}
_folder = TemporaryDirectory(prefix="layflat-meshes-", ignore_cleanup_errors=True)


def _served(piece: Piece) -> str:
    """Return the address of a mesh, written anew as binary STL: no file of the user's is served itself."""
    assert piece.file is not None  # of a mesh
    key = piece.file, piece.scale
    if key not in _meshes:
        mesh = solid(piece.file)
        mesh.apply_scale(piece.scale)
        copy = Path(_folder.name) / f"{len(_meshes)}.stl"
        mesh.export(copy)
        _meshes[key] = app.add_static_file(local_file=copy, url_path=f"/meshes/{len(_meshes)}.stl")
    return _meshes[key]
