"""View of an arm in the browser: moved by sliders, or by a recorded motion."""

import socket
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from math import degrees, radians
from time import perf_counter, sleep
from typing import Any, Self

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.bridge.mjcf import JOINT_BODY_SCALE, quaternion
from layflat.bridge.pieces import COLOURS, Piece
from layflat.bridge.view.scenery import FIELD_OF_VIEW, FLOOR_SQUARE, scenery, stroke_arcs, viewpoint
from layflat.errors import InputError
from layflat.machine import Machine

LOCAL_HOST = "127.0.0.1"  # reachable from this computer only
FRAME_TIME = 1.0 / 30.0  # s
PLAYBACK_SPEEDS = ("0.1 x", "0.25 x", "0.5 x", "1 x", "2 x")
WORKING_STROKE_COLOUR = (40, 120, 200)
STOP_RANGE_COLOUR = (190, 60, 40)  # between working stroke and stops
STOP_PROXIMITY = radians(0.05)  # angle to a stop that counts as at the stop, rad


@dataclass(frozen=True)
class PlayedMotion:
    """Recorded motion of an arm that is played."""

    times: Array  # s, (n,)
    angles: Array  # rad, (n, joints)

    def angles_at(self, time: float) -> Array:
        """Return the angles (rad, (joints,)) at a time, s, by linear interpolation; the first or last ones outside."""
        angles: Array = np.array([np.interp(time, self.times, column) for column in self.angles.T])
        return angles


class Viewer:
    """Page with an arm, served to this computer only until it is closed; best used in a `with` block.

    Args:
        machine: the machine.
        angles: initial angles, rad, an item a joint.
        motion: recorded motion that is played.
        port: port of the page; 0: any free one.

    Attributes:
        address: address of the page.
        sliders: sliders of the joint angles, by joint; their values are in degrees.

    Raises:
        InputError: the port is in use, the arm is of a kind without bodies, or a mesh can't be read.
        MissingExtraError: the extra `view` is not installed.
    """

    def __init__(
        self, machine: Machine, angles: Sequence[float], *, motion: PlayedMotion | None = None, port: int = 8080
    ) -> None:
        """Start the server, and build scene and controls; the server is stopped if that fails."""
        viser = extras.import_extra("view", "viser")
        self._shown = scenery(machine, angles)
        self._motion, self._angles = motion, np.array(angles, float)
        with redirect_stdout(StringIO()):  # the caller reports the address
            self._server = viser.ViserServer(host=LOCAL_HOST, port=_free_port(port), label=machine.name, verbose=False)
        self.address = f"http://{LOCAL_HOST}:{self._server.get_port()}"
        try:
            self._build_scene()
            self._add_controls()
            self._show_pose()
        except BaseException:
            self.close()
            raise

    def serve(self, stopped: Callable[[], bool]) -> None:
        """Show the arm and play its motion until `stopped()` is true."""
        before = perf_counter()
        while not stopped():
            sleep(FRAME_TIME)
            now = perf_counter()
            self.advance(now - before)
            before = now

    def advance(self, seconds: float) -> None:
        """Advance the motion, unless it is paused, by seconds x its speed; after its end it starts again."""
        if self._motion is None or not self.playing.value:
            return
        begin, end = self._motion.times[[0, -1]]
        time = self.time.value + seconds * float(self.speed.value.split()[0])
        self.time.value = float(time if time <= end else begin)

    def show_angles(self, angles: Sequence[float] | Array) -> None:
        """Set sliders and arm to angles, rad, an item a joint."""
        self._angles = np.array(angles, float)
        for slider, angle in zip(self.sliders.values(), np.degrees(self._angles).tolist(), strict=True):
            slider.value = float(np.clip(angle, slider.min, slider.max))
        self._show_pose()

    def close(self) -> None:
        """End the page."""
        with redirect_stdout(StringIO()):
            self._server.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _build_scene(self) -> None:
        """Build the scene: camera, light, floor, the arm's frames and pieces, and arcs of the strokes."""
        scene, shown = self._server.scene, self._shown
        eye = viewpoint(shown.placed(self._angles), shown.floor, 1.0)
        camera = self._server.initial_camera
        camera.position, camera.look_at, camera.fov = eye.position, eye.centre, radians(FIELD_OF_VIEW)
        scene.set_up_direction("+z")
        scene.configure_environment_map(None)  # it would be loaded from another host
        scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(200, 200, 200), intensity=2.5)
        greys = {"cell_color": (215, 215, 215), "section_color": (170, 170, 170)}
        scene.add_grid(
            "/floor", 20.0, 20.0, cell_size=FLOOR_SQUARE, section_size=10 * FLOOR_SQUARE, fade_distance=8.0,
            position=(0.0, 0.0, shown.floor), **greys,
        )  # fmt: skip
        frames = shown.frames(self._angles)
        self._frames = [scene.add_frame(f"/arm/{name}", show_axes=False) for name in self._names()]
        for handle, (axes, origin) in zip(self._frames, frames, strict=True):
            handle.wxyz, handle.position = quaternion(axes), origin
        self._bodies = [
            handle
            for count, (frame, piece) in enumerate(shown.pieces)
            if (handle := _add_piece(scene, f"/arm/{self._names()[frame]}/{count}", piece)) and piece.of == "joint"
        ]
        self._arcs = []
        for joint, name in enumerate(shown.machine.joints):
            before = self._names()[joint]
            for key, colour, points in zip(
                ("works", "stops"), (WORKING_STROKE_COLOUR, STOP_RANGE_COLOUR), stroke_arcs(shown, joint), strict=True
            ):
                if len(points):
                    path = f"/arm/{before}/{name}-{key}"
                    self._arcs.append(scene.add_line_segments(path, points.astype(np.float32), colour, thickness=0.004))

    def _names(self) -> list[str]:
        """Return the names of all frames: base, joints and tool, numbered."""
        # With numbers, as a joint may have the name of the base or the tool.
        return [f"{i}-{name}" for i, name in enumerate(["base", *self._shown.machine.joints, "tool"])]

    def _add_controls(self) -> None:
        """Add the sliders of the joints (deg), the player of a recorded motion, and the switches of visible parts."""
        gui, machine = self._server.gui, self._shown.machine
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.add_markdown(f"**{machine.name}**: {machine.title}")
        if self._motion is not None:
            self._add_player(self._motion)
        self.sliders: dict[str, Any] = {}
        with gui.add_folder("Joints (deg)"):
            for (name, joint), angle in zip(machine.joints.items(), self._angles, strict=True):
                stop, works = degrees(joint.stops.mechanical_stroke) / 2, degrees(joint.stops.working_stroke) / 2
                marks = tuple((round(at, 1), f"{at:.0f}") for at in (-works, 0.0, works))
                at = float(np.clip(degrees(angle), -stop, stop))
                slider = gui.add_slider(name, -stop, stop, 0.1, at, marks=marks, hint="marks: the working stroke")
                slider.on_update(lambda _: self._apply_sliders())
                self.sliders[name] = slider
        self.text = gui.add_markdown("")
        for label, handles in (("Bodies of the joints", self._bodies), ("Strokes", self._arcs)):
            self._add_switch(label, handles)

    def _add_switch(self, label: str, handles: list[Any]) -> None:
        """Add a checkbox, checked at first, that shows or hides objects of the scene."""
        switch = self._server.gui.add_checkbox(label, True)

        def show(_: Any) -> None:
            for handle in handles:
                handle.visible = switch.value

        switch.on_update(show)

    def _add_player(self, motion: PlayedMotion) -> None:
        """Add slider of time (s), play button and speed of a recorded motion."""
        gui, (begin, end) = self._server.gui, motion.times[[0, -1]].tolist()
        with gui.add_folder("Run"):
            self.time = gui.add_slider("time (s)", begin, end, max((end - begin) / 2000.0, 1e-4), begin)
            self.playing = gui.add_checkbox("play", True)
            self.speed = gui.add_dropdown("speed", PLAYBACK_SPEEDS, initial_value="1 x")
        self.time.on_update(lambda _: self._apply_motion())

    def _apply_motion(self) -> None:
        """Set sliders and arm to the motion's angles at the present time."""
        assert self._motion is not None
        self.show_angles(self._motion.angles_at(self.time.value))

    def _apply_sliders(self) -> None:
        """Set the arm to the sliders' angles, unless a motion is played."""
        if self._motion is not None and self.playing.value:
            return
        self._angles = np.radians([slider.value for slider in self.sliders.values()])
        self._show_pose()

    def _show_pose(self) -> None:
        """Show the arm at the present angles, its tip position, and the joints beyond stroke or at a stop."""
        shown, angles = self._shown, self._angles
        with self._server.atomic():
            for handle, (axes, origin) in zip(self._frames, shown.frames(angles), strict=True):
                handle.wxyz, handle.position = quaternion(axes), origin
        x, y, z = 1e3 * shown.tip(angles)
        lines = [
            f"Tip: x {x:.0f} mm, y {y:.0f} mm, z {z:.0f} mm. Squares of the floor are {1e3 * FLOOR_SQUARE:.0f} mm."
        ]
        for (name, joint), angle in zip(shown.machine.joints.items(), angles, strict=True):
            if abs(angle) >= 0.5 * joint.stops.mechanical_stroke - STOP_PROXIMITY:
                lines.append(f"**{name}** is at its stop.")
            elif abs(angle) > 0.5 * joint.stops.working_stroke + STOP_PROXIMITY:
                lines.append(f"**{name}** is beyond its working stroke.")
        self.text.content = "\n\n".join(lines)


def _free_port(port: int) -> int:
    """Return the port, or a free one for 0; raise InputError if it is in use."""
    with socket.socket() as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((LOCAL_HOST, port))
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            right = "give another, or 0 for any that is free"
            raise InputError(f"port {port} can't be had ({reason})", where="port", right=right) from None
        return int(trial.getsockname()[1])


def _add_piece(scene: Any, name: str, piece: Piece) -> Any:
    """Add a piece to the scene, by its path below the path of its frame, and return its handle."""
    larger = JOINT_BODY_SCALE if piece.of == "joint" else 1.0
    put: dict[str, Any] = {"wxyz": quaternion(piece.axes), "position": piece.position}
    put["color"] = tuple(round(255 * part) for part in COLOURS[piece.of][:3])
    if piece.kind == "box":
        return scene.add_box(name, dimensions=piece.size, **put)
    if piece.kind == "sphere":
        return scene.add_icosphere(name, radius=0.5 * piece.size[0], **put)
    if piece.kind == "cylinder":
        return scene.add_cylinder(name, radius=0.5 * larger * piece.size[0], height=larger * piece.size[1], **put)
    vertices, faces = _piece_mesh(piece)
    return scene.add_mesh_simple(name, vertices, faces, **put)


def _piece_mesh(piece: Piece) -> tuple[Array, Array]:
    """Return vertices (m) and faces of a mesh, or of a capsule about its middle, in the frame of the piece."""
    if piece.file is not None:
        from layflat.bridge.meshes import load_mesh  # noqa: PLC0415

        mesh = load_mesh(piece.file)
        return mesh.vertices * np.array(piece.scale), mesh.faces
    trimesh = extras.import_extra("view", "trimesh")
    diameter, length = piece.size
    mesh = trimesh.creation.capsule(height=length, radius=0.5 * diameter, count=(24, 24))
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return mesh.vertices, mesh.faces
