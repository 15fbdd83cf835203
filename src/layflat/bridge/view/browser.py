"""An arm in the browser: moved by sliders, or as it went in a run."""

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
from layflat.bridge.mjcf import IN_FRONT, quaternion
from layflat.bridge.pieces import COLOURS, Piece
from layflat.bridge.view.scenery import FIELD, SQUARE, scenery, stroke_arcs, viewpoint
from layflat.errors import InputError
from layflat.machine import Machine

HERE = "127.0.0.1"  # nobody else looks in
FRAME = 1.0 / 30.0  # s
SPEEDS = ("0.1 x", "0.25 x", "0.5 x", "1 x", "2 x")
WORKS, STOPS = (40, 120, 200), (190, 60, 40)  # colours of the working stroke, and of what is left to the stops
NEAR = radians(0.05)  # of a stop


@dataclass(frozen=True)
class Motion:
    """Motion of an arm, to be played."""

    times: Array  # s, (n,)
    angles: Array  # rad, (n, joints)

    def at(self, time: float) -> Array:
        """Return the angles (rad, (joints,)) at a time, s."""
        found: Array = np.array([np.interp(time, self.times, column) for column in self.angles.T])
        return found


class Viewer:
    """A page with an arm, on this machine alone, until it is closed; best used in a `with` block.

    Args:
        machine: whose arm it is.
        angles: at first, rad, an item a joint.
        motion: what it did, to be played.
        port: of the page; 0: any that is free.

    Attributes:
        address: of the page.
        sliders: what sets the angle of each joint, by its name; their values are in degrees.

    Raises:
        InputError: the port is in use, the arm is of a kind without bodies, or a mesh can't be read.
        MissingExtraError: what serves pages is not installed.
    """

    def __init__(
        self, machine: Machine, angles: Sequence[float], *, motion: Motion | None = None, port: int = 8080
    ) -> None:
        viser = extras.module("view", "viser")
        self._shown = scenery(machine, angles)
        self._motion, self._angles, self._told = motion, np.array(angles, float), 0.0
        with redirect_stdout(StringIO()):  # what viser has to say is said by who calls
            self._server = viser.ViserServer(host=HERE, port=_free(port), label=machine.name, verbose=False)
        self.address = f"http://{HERE}:{self._server.get_port()}"
        try:
            self._build()
            self._add_controls()
            self._show()
        except BaseException:
            self.close()
            raise

    def serve(self, stopped: Callable[[], bool]) -> None:
        """Show the arm, and play its motion when asked, until it is to stop."""
        before = perf_counter()
        while not stopped():
            sleep(FRAME)
            now = perf_counter()
            self.advance(now - before)
            before = now

    def advance(self, seconds: float) -> None:
        """Advance the time: the motion goes on where it is played, and begins anew at its end."""
        if self._motion is None or not self.playing.value:
            return
        begin, end = self._motion.times[[0, -1]]
        time = self.time.value + seconds * float(self.speed.value.split()[0])
        self.time.value = float(time if time <= end else begin)

    def close(self) -> None:
        """End the page."""
        with redirect_stdout(StringIO()):
            self._server.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _build(self) -> None:
        scene, shown = self._server.scene, self._shown
        eye = viewpoint(shown.placed(self._angles), shown.floor, 1.0)
        camera = self._server.initial_camera
        camera.position, camera.look_at, camera.fov = eye.place, eye.centre, radians(FIELD)
        scene.set_up_direction("+z")
        scene.configure_environment_map(None)  # it would come from elsewhere
        scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(200, 200, 200), intensity=2.5)
        greys = {"cell_color": (215, 215, 215), "section_color": (170, 170, 170)}
        scene.add_grid(
            "/floor", 20.0, 20.0, cell_size=SQUARE, section_size=10 * SQUARE, fade_distance=8.0,
            position=(0.0, 0.0, shown.floor), **greys,
        )  # fmt: skip
        frames = shown.frames(self._angles)
        self._frames = [scene.add_frame(f"/arm/{name}", show_axes=False) for name in self._names()]
        for handle, (axes, origin) in zip(self._frames, frames, strict=True):
            handle.wxyz, handle.position = quaternion(axes), origin
        self._bodies = [
            handle
            for count, (frame, piece) in enumerate(shown.pieces)
            if (handle := _add(scene, f"/arm/{self._names()[frame]}/{count}", piece)) and piece.of == "joint"
        ]
        self._arcs = []
        for joint, name in enumerate(shown.machine.joints):
            before = self._names()[joint]
            for key, colour, points in zip(("works", "stops"), (WORKS, STOPS), stroke_arcs(shown, joint), strict=True):
                if len(points):
                    path = f"/arm/{before}/{name}-{key}"
                    self._arcs.append(scene.add_line_segments(path, points.astype(np.float32), colour, thickness=0.004))

    def _names(self) -> list[str]:
        # With numbers, as a joint may be called as the base or the tool.
        return [f"{i}-{name}" for i, name in enumerate(["base", *self._shown.machine.joints, "tool"])]

    def _add_controls(self) -> None:
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
                slider.on_update(lambda _: self._take())
                self.sliders[name] = slider
        self.text = gui.add_markdown("")
        for label, handles in (("Bodies of the joints", self._bodies), ("Strokes", self._arcs)):
            self._add_switch(label, handles)

    def _add_switch(self, label: str, handles: list[Any]) -> None:
        switch = self._server.gui.add_checkbox(label, True)

        def show(_: Any) -> None:
            for handle in handles:
                handle.visible = switch.value

        switch.on_update(show)

    def _add_player(self, motion: Motion) -> None:
        gui, (begin, end) = self._server.gui, motion.times[[0, -1]].tolist()
        with gui.add_folder("Run"):
            self.time = gui.add_slider("time (s)", begin, end, max((end - begin) / 2000.0, 1e-4), begin)
            self.playing = gui.add_checkbox("play", True)
            self.speed = gui.add_dropdown("speed", SPEEDS, initial_value="1 x")
        self.time.on_update(lambda _: self._follow())

    def _follow(self) -> None:
        """Put sliders and arm where the motion is."""
        assert self._motion is not None
        self._angles = self._motion.at(self.time.value)
        self._told = perf_counter()
        for slider, angle in zip(self.sliders.values(), np.degrees(self._angles).tolist(), strict=True):
            slider.value = float(np.clip(angle, slider.min, slider.max))
        self._show()

    def _take(self) -> None:
        """Put the arm where the sliders are; those that follow a motion have nothing to say."""
        if self._motion is not None and self.playing.value:
            return
        self._angles = np.radians([slider.value for slider in self.sliders.values()])
        self._show()

    def _show(self) -> None:
        shown, angles = self._shown, self._angles
        with self._server.atomic():
            for handle, (axes, origin) in zip(self._frames, shown.frames(angles), strict=True):
                handle.wxyz, handle.position = quaternion(axes), origin
        x, y, z = 1e3 * shown.tip(angles)
        lines = [f"Tip: x {x:.0f} mm, y {y:.0f} mm, z {z:.0f} mm. Squares of the floor are {1e3 * SQUARE:.0f} mm."]
        for (name, joint), angle in zip(shown.machine.joints.items(), angles, strict=True):
            if abs(angle) >= 0.5 * joint.stops.mechanical_stroke - NEAR:
                lines.append(f"**{name}** is at its stop.")
            elif abs(angle) > 0.5 * joint.stops.working_stroke + NEAR:
                lines.append(f"**{name}** is beyond its working stroke.")
        self.text.content = "\n\n".join(lines)


def _free(port: int) -> int:
    """Return a port of which nobody makes use; raise InputError if it is taken."""
    with socket.socket() as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HERE, port))
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            right = "give another, or 0 for any that is free"
            raise InputError(f"port {port} can't be had ({reason})", where="port", right=right) from None
        return int(trial.getsockname()[1])


def _add(scene: Any, name: str, piece: Piece) -> Any:
    """Add a piece to a frame of the scene."""
    larger = IN_FRONT if piece.of == "joint" else 1.0
    put: dict[str, Any] = {"wxyz": quaternion(piece.axes), "position": piece.place}
    put["color"] = tuple(round(255 * part) for part in COLOURS[piece.of][:3])
    if piece.kind == "box":
        return scene.add_box(name, dimensions=piece.size, **put)
    if piece.kind == "sphere":
        return scene.add_icosphere(name, radius=0.5 * piece.size[0], **put)
    if piece.kind == "cylinder":
        return scene.add_cylinder(name, radius=0.5 * larger * piece.size[0], height=larger * piece.size[1], **put)
    vertices, faces = _solid(piece)
    return scene.add_mesh_simple(name, vertices, faces, **put)


def _solid(piece: Piece) -> tuple[Array, Array]:
    if piece.file is not None:
        from layflat.bridge.meshes import solid  # noqa: PLC0415

        mesh = solid(piece.file)
        return mesh.vertices * np.array(piece.scale), mesh.faces
    trimesh = extras.module("view", "trimesh")
    diameter, length = piece.size
    mesh = trimesh.creation.capsule(height=length, radius=0.5 * diameter, count=(24, 24))
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return mesh.vertices, mesh.faces
