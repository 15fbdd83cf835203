"""Views that move the arm: jogging while a button is held, and targets by angles, by tip position, or by a click.

An invisible element keeps the operator's lease alive (minder.js).
"""

from collections.abc import Callable
from functools import partial
from math import degrees, radians
from typing import Any

import numpy as np
from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.arm_scene import ArmScene
from layflat.pages.look.theme import clamp_number, finite_number
from layflat.pages.panel.desk import Controls, Desk
from layflat.pages.panel.moves import SequenceStep, active_outputs, read_target
from layflat.pages.panel.search import SEARCH_TIMEOUT, find_angles
from layflat.rig.device_state import DeviceState
from layflat.rig.session import RigSnapshot

Jogs = list[tuple[int, int]]
"""Jogged joints: index of the joint, and direction, -1 or 1."""
JOG_SPEEDS = (2.0, 60.0, 15.0)  # min, max and initial speed, deg/s


class Minder(Element, component="minder.js"):
    """Invisible element that renews the lease as long as its page is alive and in view."""

    def __init__(self, renewed: Callable[[int, Jogs], object], stopped: Callable[[], object]) -> None:
        """Register `renewed`, called with the last beat and the jogged joints, and `stopped`, called on Escape."""
        super().__init__()
        self.on("renew", lambda event: renewed(*_read(event)))
        self.on("stop", lambda _: stopped())

    def beat(self, number: int) -> None:
        """Send the page a beat."""
        self.run_method("beat", number)


def _read(event: GenericEventArguments) -> tuple[int, Jogs]:
    """Return beat and jogged joints of a renewal, whose texts are "joint:direction"; 0 and [] where it is malformed."""
    args: Any = event.args
    try:
        jogs = [
            (int(joint), 1 if int(direction) > 0 else -1)
            for joint, direction in (jog.split(":") for jog in args["jogs"])
        ]
        return int(args["beat"]), jogs
    except (TypeError, KeyError, ValueError, AttributeError):
        return 0, []


class JogView:
    """View with a row a joint: angle, target, and two buttons that jog it while they are held."""

    def __init__(self, desk: Desk) -> None:
        """Build the view within the current element."""
        self._desk, self._count = desk, len(desk.first.joints)
        slowest, fastest, usual = JOG_SPEEDS
        with ui.row().classes("lf-line"):
            ui.label("Speed while a button is held:").props('id="jog-speed"')
            self.speed = ui.slider(min=slowest, max=fastest, step=1.0, value=usual).classes("lf-slider")
            self.speed.props('aria-labelledby="jog-speed"')
            ui.label().bind_text_from(self.speed, "value", lambda x: f"{clamp_number(x, *JOG_SPEEDS):.0f} deg/s")
        self.buttons: list[ui.button] = []
        self._shown: list[ui.label] = []
        with ui.element("div").classes("lf-joints"):
            for i, name in enumerate(desk.first.joints):
                ui.label(name).classes("lf-name")
                self._add_jog_button(i, -1, "remove", f"{name}, backwards")
                self._shown.append(ui.label("-").classes("lf-number"))
                self._add_jog_button(i, 1, "add", f"{name}, forwards")
        ui.label("By keyboard: go to a button with Tab, hold Space. Escape stops.").classes("lf-quiet lf-small")

    def _add_jog_button(self, joint: int, direction: int, icon: str, name: str) -> None:
        button = theme.button("", icon=icon, hint=f"{name}: hold to move")
        button.props(f'data-jog="{joint}:{direction}" no-caps').classes("lf-jog")
        self.buttons.append(button)

    def speeds(self, jogs: Jogs) -> list[float]:
        """Return the demanded velocity of each joint, rad/s: plus or minus the slider's speed, or 0.

        Opposite directions of a joint cancel each other, and indices of no joint are ignored.
        """
        speed = radians(clamp_number(self.speed.value, *JOG_SPEEDS))
        directions = [0.0] * self._count
        for joint, direction in jogs:
            if 0 <= joint < self._count:
                directions[joint] += direction
        return [speed * min(max(direction, -1.0), 1.0) for direction in directions]

    def refresh(self, shot: RigSnapshot | None, can_move: bool) -> None:
        """Show angles and targets of the joints, "-" without a snapshot; enable the buttons if `can_move`.

        That is whether this page may move them.
        """
        for j, label in enumerate(self._shown):
            text = "-"
            if shot is not None:
                text = f"{degrees(shot['averaged_angle'][j]):.1f} deg, target {degrees(shot['demand'][j]):.1f}"
            label.set_text(text)
        for button in self.buttons:
            button.set_enabled(can_move)


class OutputsView:
    """View with a row a digital output of the machine: its state, and a button that switches it."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build the view within the current element."""
        self._desk, self._controls, names = desk, controls, desk.first.interface.outputs
        self._rows: dict[str, tuple[ui.label, ui.button]] = {}
        self._on: frozenset[str] | None = None
        with ui.element("div").classes("lf-outputs"):
            for name in names:
                ui.label(name).classes("lf-name")
                shown = ui.label("-").classes("lf-number").props("role=status")
                button = theme.button(f"Switch {name} on", partial(self._switch, name))
                self._rows[name] = shown, button

    def refresh(self, shot: RigSnapshot | None, drives: bool) -> None:
        """Show which outputs are on; enable the buttons if this page `drives` and the device has not dumped its air."""
        on = active_outputs(self._desk.first, shot) if shot is not None else frozenset()
        obeys = shot is not None and int(shot["device"]) != DeviceState.DUMPED
        for name, (shown, button) in self._rows.items():
            button.set_enabled(drives and obeys)
            if on != self._on:
                shown.set_text("on" if name in on else "off")
                button.set_text(f"Switch {name} {'off' if name in on else 'on'}")
                button.props["aria-label"] = button.text
                button.update()
        self._on = on

    def _switch(self, name: str) -> None:
        """Switch an output to the opposite of its state in the last cycle, if there is one."""
        shot = self._desk.snapshot()
        if shot is not None:
            self._controls.switch(name, name not in active_outputs(self._desk.first, shot))


class TargetView:
    """View of a target: fields of angles and of the tip's position, shown in the scene before the arm goes there."""

    def __init__(self, desk: Desk, controls: Controls, scene: Callable[[], ArmScene]) -> None:
        """Build it; `scene` returns the scene that shows the target."""
        self._desk, self._controls, self._scene, self._filling = desk, controls, scene, False
        self._next: Array | None = None  # tip position that is searched next, m
        self._searches = False
        self.angles: dict[str, ui.number] = {}
        with ui.element("div").classes("lf-fields"):
            for name, joint in desk.first.joints.items():
                half = degrees(joint.stops.working_stroke) / 2
                wrong = partial(self._angle_problem, name)
                field = ui.number(f"{name} (deg)", value=0.0, step=1.0, precision=2, validation=wrong)
                field.on_value_change(self._show_entered)
                self.angles[name] = field.props("dense outlined")
                field.props(f'hint="-{half:.0f} to {half:.0f}"')
        with ui.element("div").classes("lf-fields"):
            axes = "xyz" if desk.inverse.directions == 3 else "xy"
            self.place = {
                axis: ui.number(f"tip {axis} (mm)", step=1.0, precision=1).props("dense outlined") for axis in axes
            }
            for field in self.place.values():
                field.on("keydown.enter", self._find)
            theme.button("Find angles", self._find, icon="my_location", hint="Find angles that bring the tip there")
        self.status = ui.label("").classes("lf-told").props("role=alert")
        self.cancel = theme.button("Cancel the search", self._end_search, icon="close")
        ui.context.client.on_delete(lambda: desk.worker.forget(self))
        self.cancel.set_visibility(False)
        with ui.row().classes("lf-line"):
            self.go = theme.button("Go to target", self._start_motion, icon="near_me", kind="primary")
            theme.button("Take present angles", self._take_present_angles, icon="pin_drop")
        ui.label("Or click the green surface in the picture: places that the tip can reach.").classes(
            "lf-quiet lf-small"
        )

    async def clicked(self, place: Array) -> None:
        """Enter a clicked position of the tip in the base frame, m, (3,), and compute and enter angles for it."""
        for axis, coordinate in zip(self.place, place.tolist(), strict=False):
            self.place[axis].value = round(1e3 * coordinate, 1)
        await self._find()

    def refresh(self, can_move: bool) -> None:
        """Enable the buttons that may be used now; `can_move`: whether this page may move the arm."""
        self.go.set_enabled(can_move and self.target_angles() is not None)

    def target_angles(self) -> tuple[float, ...] | None:
        """Return the target, rad; None where a field holds no angle inside its joint's stroke."""
        try:
            return read_target(
                self._desk.first, {name: finite_number(field.value) for name, field in self.angles.items()}
            )
        except LayflatError:
            return None

    def _angle_problem(self, joint: str, value: float | None) -> str | None:
        """Return the message about an angle (deg) that its joint can't take; None where it can."""
        try:
            read_target(self._desk.first, {**dict.fromkeys(self._desk.first.joints, 0.0), joint: finite_number(value)})
        except LayflatError as error:
            return str(error)
        return None

    def _show_entered(self) -> None:
        """Show the entered target in the scene, none if it is invalid, and its tip position (mm) in the fields."""
        if self._filling:
            return
        target = self.target_angles()
        self._scene().show_target(target)
        if target is not None:
            tip = 1e3 * self._desk.inverse.tip(np.array(target))
            for axis, coordinate in zip(self.place, tip.tolist(), strict=False):
                self.place[axis].value = round(coordinate, 1)

    async def _find(self) -> None:
        """Compute and enter angles for the tip position in the fields; say so if one of them holds no number.

        There is one search at a time, and the newest position wins.
        """
        place = [finite_number(field.value) for field in self.place.values()]
        if None in place:
            self.status.set_text("Give a number of millimetres in each field of the tip.")
            return
        self._next = 1e-3 * np.array(place, float)
        if self._searches:
            return
        self._searches = True
        self.cancel.set_visibility(True)
        try:
            while self._next is not None:
                await self._search_angles()
        finally:
            self._searches = False
            self.cancel.set_visibility(False)

    def _end_search(self) -> None:
        self._desk.worker.cancel(self)

    async def _search_angles(self) -> None:
        """Enter the angles nearest the present ones for the tip position `_next`, unless a newer one comes.

        Errors are shown in the view, not raised.
        """
        desk, shot, place, self._next = self._desk, self._desk.snapshot(), self._next, None
        near = np.array(shot["averaged_angle"] if shot is not None else np.zeros(len(self.angles)))
        self.status.set_text("searching")
        with theme.show_errors_on(self.status):
            call = partial(desk.worker.call, limit=SEARCH_TIMEOUT, what="the search for angles", by=self)
            angles = await call(find_angles, desk.first, place, near)
            self.status.set_text("")
            if self._next is None:
                self._enter_angles(angles)

    def _enter_angles(self, angles: Array) -> None:
        """Enter angles (rad) in the fields, in degrees, and show them as the target."""
        self._filling = True
        for field, angle in zip(self.angles.values(), angles.tolist(), strict=True):
            field.value = round(degrees(angle), 2)
        self._filling = False
        self._show_entered()

    def _take_present_angles(self) -> None:
        """Enter the present angles as the target, if the rig is connected."""
        shot = self._desk.snapshot()
        if shot is not None:
            self._enter_angles(np.array(shot["averaged_angle"]))

    def _start_motion(self) -> None:
        """Start a motion to the entered target, or show why it is refused; without effect while a field is invalid."""
        if (target := self.target_angles()) is None:
            return  # the field shows the problem
        with theme.show_errors_on(self.status):
            self._controls.start_sequence([SequenceStep(target)])
