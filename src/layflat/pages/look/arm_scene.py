"""Scene of an arm in three dimensions: present and target configuration, path of the tip, reachable surface."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from nicegui import app, events, ui
from nicegui.element import Element
from nicegui.elements.scene.scene_object3d import Object3D
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.bridge.meshes import binary_stl, load_mesh
from layflat.bridge.pieces import Piece
from layflat.bridge.view.scenery import FIELD_OF_VIEW, scenery, viewpoint
from layflat.machine import Machine
from layflat.solids.moving import MovingSolids

COLOURS = {"link": "#aab4c0", "joint": "#29333f", "tip": "#c05a00"}  # far apart in black and white, too
MAX_FRAME_RATE = 10  # frames a second while something changes: a browser without a graphics device renders them itself
GHOST_COLOUR = "#1b6a8f"
GHOST_SCALE = 0.97  # scale of the target arm, so that the arm hides it on arrival
MIN_DRAWN_ROTATION = 1e-3  # rotation of a joint that makes it redrawn, rad: above a sensor's noise
MAX_TRAIL_POINTS, TRAIL_STEP = 400, 0.002  # points shown of the tip's path, and their spacing, m
FLOOR_OFFSET = 0.002  # height above the floor of a surface drawn on it, m
CYLINDER_AXES = np.array(
    [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
)  # columns: axes of a three.js cylinder (along y) in a piece (along z)
WHITE_PIXEL = (
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC"
)
"""Texture of one white pixel, which the material of a surface colours."""


class RenderOnChange(Element, component="sparing.js"):
    """Invisible element that makes a scene render only when it has changed."""

    def __init__(self, scene: ui.scene) -> None:
        """Attach it to a scene that is built already and holds no texts."""
        super().__init__()
        self._props["scene"] = scene.id


class ArmScene:
    """Scene of a machine's arm.

    Args:
        machine: machine whose arm it is.
        label: description of the scene, for a reader of screens.
        clicked: called with the clicked point of the reachable surface, in the base frame, m, (3,); a coroutine that it
            returns is awaited.
    """

    def __init__(self, machine: Machine, *, label: str, clicked: Callable[[Array], object] | None = None) -> None:
        """Build the scene within the current element: floor, arm at mid-stroke, and neither target nor surface."""
        rest = [0.0] * len(machine.joints)
        self._shown, self._clicked = scenery(machine, rest), clicked
        self._solids: list[tuple[MovingSolids, Object3D]] = []
        self.scene = ui.scene(
            grid=False, background_color="#eef1f4", fps=MAX_FRAME_RATE, on_click=self._click, click_events=["click"],
            camera=ui.scene.perspective_camera(fov=FIELD_OF_VIEW, near=0.05, far=30),
        ).classes("w-full")  # fmt: skip
        self.scene.style("height: 20rem").props(f'role=img aria-label="{label}"')
        RenderOnChange(self.scene)
        self._trail: deque[list[float]] = deque(maxlen=MAX_TRAIL_POINTS)
        self._posed = np.full(len(rest), np.inf)
        with self.scene as scene:
            with scene.group() as self._floor:
                self._draw_floor()
            self._arm = self._build_arm(None)
            self._ghost = self._build_arm(GHOST_COLOUR)
            self._way = scene.point_cloud([], point_size=0.012).material("#c05a00")
            self._reach: Object3D | None = None
        self.show_target(None)
        self.show_pose(rest)
        eye = viewpoint(self._shown.placed(rest), self._shown.floor, 1.5)
        (x, y, z), (to_x, to_y, to_z) = eye.position.tolist(), eye.centre.tolist()
        self.scene.move_camera(x, y, z, to_x, to_y, to_z, 0.0, 0.0, 1.0, duration=0.0)

    def show_pose(self, angles: Sequence[float] | Array) -> None:
        """Draw the arm at these joint angles, rad, and extend the path of its tip.

        Nothing is drawn unless a joint has rotated by `MIN_DRAWN_ROTATION` since the last drawing.
        """
        if float(np.abs(angles - self._posed).max()) < MIN_DRAWN_ROTATION:
            return
        self._posed = np.array(angles, float)
        self._place(self._arm, angles)
        self._place_solids()
        tip = self._shown.level @ self._shown.tip(angles)
        if not self._trail or float(np.abs(tip - self._trail[-1]).max()) > TRAIL_STEP:
            self._trail.append(tip.tolist())
            self._way.set_points(list(self._trail))

    def show_machine(self, machine: Machine) -> None:
        """Draw another machine of the same joints, by rods; neither the path of the tip nor a target remains."""
        self.show_solids([])
        for group in (*self._arm, *self._ghost):
            group.delete()
        self._shown = scenery(machine, [0.0] * len(machine.joints))
        with self.scene:
            self._arm, self._ghost = self._build_arm(None), self._build_arm(GHOST_COLOUR)
        self._floor.move(z=self._shown.floor - self._drawn_floor)
        self._trail.clear()
        self.show_target(None)
        angles, self._posed = self._posed, np.full(len(machine.joints), np.inf)
        self.show_pose(angles)

    def show_solids(self, solids: Sequence[MovingSolids]) -> None:
        """Draw the arm by solids in place of its rods, and the floor below them; by its rods where there are none."""
        for _ in self.build_solids(solids):
            pass

    def build_solids(self, solids: Sequence[MovingSolids]) -> Iterator[None]:
        """Do the work of `show_solids` in steps, of which the last one makes them visible."""
        built = [(one, self._add_group()) for one in solids]
        for one, group in built:
            for colour, triangles in one.triangles.items():
                with self.scene, group:
                    self.scene.stl(_served_stl(binary_stl(triangles, normals=True))).material(colour)
                yield
        for _, group in self._solids:
            group.delete()
        self._solids = built
        for _, group in built:
            group.visible()
        low = min((_lowest(one, self._shown.level) for one in solids if one.frame == 0), default=self._shown.floor)
        for group in self._arm[1:-1]:
            group.visible(not solids)
        self._arm[0].visible(low - self._shown.floor > FLOOR_OFFSET or not solids)  # the post below the foot
        self._shown = replace(self._shown, floor=min(low, self._shown.floor))
        self._floor.move(z=self._shown.floor - self._drawn_floor)
        self._place_solids()

    def show_target(self, angles: Sequence[float] | Array | None) -> None:
        """Draw the target arm at these joint angles, rad; None hides it."""
        for group in self._ghost:
            group.visible(angles is not None)
        if angles is not None:
            self._place(self._ghost, angles)

    def show_reachable(self, corners: Array, is_reachable: NDArray[np.bool_], *, on_floor: bool = False) -> None:
        """Show the surface of positions that the tip can reach, in place of the previous one.

        A cell of the grid is part of it where the tip can reach all of its corners.

        Args:
            corners: grid of positions in the base frame, m, (rows, columns, 3).
            is_reachable: mask of those that the tip can reach, (rows, columns).
            on_floor: whether the surface is projected onto the floor.
        """
        rooms = corners @ self._shown.level.T
        if on_floor:
            rooms[..., 2] = self._shown.floor + FLOOR_OFFSET
        grid = [
            [at if ok else None for at, ok in zip(*row, strict=True)]
            for row in zip(rooms.tolist(), is_reachable, strict=True)
        ]
        if self._reach is not None:
            self._reach.delete()
        with self.scene as scene:
            self._reach = scene.texture(WHITE_PIXEL, grid).material("#2f7a2a", 0.25, "both").with_name("reach")

    def _click(self, event: events.SceneClickEventArguments) -> object:
        """Call `clicked` with the first point of the reachable surface that was hit, if any; return what it returns."""
        hits = [hit for hit in event.hits if hit.object_name == "reach"]
        if hits and self._clicked is not None:
            return self._clicked(self._shown.level.T @ np.array([hits[0].x, hits[0].y, hits[0].z]))
        return None

    def _draw_floor(self) -> None:
        """Draw the floor below the arm as a grid of 2 m by 2 m with lines every 0.1 m."""
        scene, floor = self.scene, self._shown.floor
        self._drawn_floor = floor
        for at in np.arange(-1.0, 1.01, 0.1).round(3).tolist():
            for start, end in (([at, -1.0, floor], [at, 1.0, floor]), ([-1.0, at, floor], [1.0, at, floor])):
                scene.line(start, end).material("#c3cad2" if at else "#8b95a1")

    def _build_arm(self, ghost: str | None) -> list[Object3D]:
        """Return the arm as groups of objects, one for each frame; a target has a colour `ghost` and no base."""
        groups: list[Object3D] = []
        for frame in range(len(self._shown.arm.links) + 2):
            with self.scene.group() as group:
                for place, piece in self._shown.pieces:
                    if place == frame and not (ghost and frame == 0):
                        _draw_piece(self.scene, piece, ghost)
            groups.append(group)
        return groups

    def _add_group(self) -> Object3D:
        """Return a new group that is not visible."""
        with self.scene, self.scene.group() as group:
            group.visible(False)
        return group

    def _place_solids(self) -> None:
        """Move the solids to where the arm is."""
        frames = self._shown.frames(self._posed)
        for solids, group in self._solids:
            _move(group, *solids.pose(frames, self._posed))

    def _place(self, groups: Sequence[Object3D], angles: Sequence[float] | Array) -> None:
        """Move the groups of an arm, one for each frame, to their poses at joint angles, rad."""
        for group, (axes, origin) in zip(groups, self._shown.frames(angles), strict=True):
            _move(group, axes, origin)


def _move(group: Object3D, axes: Array, origin: Array) -> None:
    """Move a group to a pose of axes (3, 3) and origin (m, (3,))."""
    group.move(*origin.round(4).tolist())
    group.rotate_R(axes.round(5).tolist())


def _lowest(solids: MovingSolids, level: Array) -> float:
    """Return the height of the lowest point of solids that move with the base, m; `level`: axes of the base."""
    return min(float((corners.reshape(-1, 3) @ level[2]).min()) for corners in solids.triangles.values())


def _draw_piece(scene: ui.scene, piece: Piece, ghost: str | None) -> None:
    """Draw the solids of a piece at its pose; with `ghost`, a colour, translucent and scaled by `GHOST_SCALE`."""
    for solid_object, axes, along in _solids(scene, piece):
        place = piece.position + piece.axes @ np.array([0.0, 0.0, along])
        solid_object.material(ghost or COLOURS[piece.of], 0.35 if ghost else 1.0)
        if ghost:
            solid_object.scale(GHOST_SCALE)
        solid_object.move(*place.tolist()).rotate_R((piece.axes @ axes).tolist())


def _solids(scene: ui.scene, piece: Piece) -> list[tuple[Object3D, Array, float]]:
    """Return the objects that make up a piece: each with its axes (3, 3) and its offset along z (m) in the piece."""
    size, straight = piece.size, np.eye(3)
    if piece.kind == "box":
        width, height, depth = size
        return [(scene.box(width, height, depth), straight, 0.0)]
    if piece.kind == "sphere":
        return [(scene.sphere(0.5 * size[0], 16, 12), straight, 0.0)]
    if piece.kind == "mesh":
        return [(scene.stl(_mesh_address(piece)), straight, 0.0)]
    radius, length = 0.5 * size[0], size[1]
    solids: list[tuple[Object3D, Array, float]] = [(scene.cylinder(radius, radius, length, 24), CYLINDER_AXES, 0.0)]
    if piece.kind == "capsule":
        solids += [(scene.sphere(radius, 16, 12), straight, end * 0.5 * length) for end in (-1.0, 1.0)]
    return solids


_meshes: dict[tuple[Path, tuple[float, ...]], str] = {}
_folder = TemporaryDirectory(prefix="layflat-meshes-", ignore_cleanup_errors=True)


def _mesh_address(piece: Piece) -> str:
    """Return the URL path of a mesh, scaled and served as binary STL: the user's files are not served themselves.

    The first call for a file and scale writes the copy to a temporary folder.
    """
    assert piece.file is not None  # of a mesh
    key = piece.file, piece.scale
    if key not in _meshes:
        mesh = load_mesh(piece.file)
        mesh.apply_scale(piece.scale)
        copy = Path(_folder.name) / f"{len(_meshes)}.stl"
        mesh.export(copy)
        _meshes[key] = app.add_static_file(local_file=copy, url_path=f"/meshes/{len(_meshes)}.stl")
    return _meshes[key]


_served: dict[str, str] = {}


def _served_stl(content: bytes) -> str:
    """Return the URL path of an STL that is served; equal ones are served once."""
    name = sha256(content).hexdigest()[:32]
    if name not in _served:
        file = Path(_folder.name) / f"{name}.stl"
        file.write_bytes(content)
        _served[name] = app.add_static_file(local_file=file, url_path=f"/solids/{name}.stl", max_cache_age=3600)
    return _served[name]
