"""Moving the arm by hand: joints that move while a button is held, and targets by angle, by place, or by a click."""

from collections.abc import Callable
from functools import partial
from math import degrees, radians

import numpy as np
from nicegui import ui

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.arm_scene import ArmScene
from layflat.pages.look.dialogs import number, within
from layflat.pages.panel.controls import Controls
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.minder import Jogs
from layflat.pages.panel.moves import Step, outputs_on
from layflat.pages.panel.search import LONGEST_SEARCH, find_posture
from layflat.pages.panel.sequences import target
from layflat.rig.driver import DeviceState
from layflat.rig.session import Snapshot

JOG_SPEEDS = (2.0, 60.0, 15.0)  # slowest, fastest, and at first, deg/s


class JogView:
    """A row a joint: where it is, where it is led, and two buttons to hold."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
        self._desk, self._count = desk, len(desk.first.joints)
        slowest, fastest, usual = JOG_SPEEDS
        with ui.row().classes("lf-line"):
            ui.label("Speed while a button is held:").props('id="jog-speed"')
            self.speed = ui.slider(min=slowest, max=fastest, step=1.0, value=usual).classes("lf-slider")
            self.speed.props('aria-labelledby="jog-speed"')
            ui.label().bind_text_from(self.speed, "value", lambda x: f"{within(x, *JOG_SPEEDS):.0f} deg/s")
        self.buttons: list[ui.button] = []
        self._shown: list[ui.label] = []
        with ui.element("div").classes("lf-joints"):
            for i, name in enumerate(desk.first.joints):
                ui.label(name).classes("lf-name")
                self._hold(i, -1, "remove", f"{name}, backwards")
                self._shown.append(ui.label("-").classes("lf-number"))
                self._hold(i, 1, "add", f"{name}, forwards")
        ui.label("By keyboard: go to a button with Tab, hold Space. Escape stops.").classes("lf-quiet lf-small")

    def _hold(self, joint: int, way: int, icon: str, name: str) -> None:
        button = theme.button("", icon=icon, hint=f"{name}: hold to move")
        button.props(f'data-jog="{joint}:{way}" no-caps').classes("lf-jog")
        self.buttons.append(button)

    def speeds(self, jogs: Jogs) -> list[float]:
        """Return how fast each joint is to move, rad/s."""
        speed = radians(within(self.speed.value, *JOG_SPEEDS))
        wanted = [0.0] * self._count
        for joint, way in jogs:
            if 0 <= joint < self._count:
                wanted[joint] += way
        return [speed * min(max(way, -1.0), 1.0) for way in wanted]

    def refresh(self, shot: Snapshot | None, fits: bool) -> None:
        """Show where the joints are; `fits`: whether they may be moved from here."""
        for j, label in enumerate(self._shown):
            text = "-"
            if shot is not None:
                text = f"{degrees(shot['averaged_angle'][j]):.1f} deg, target {degrees(shot['demand'][j]):.1f}"
            label.set_text(text)
        for button in self.buttons:
            button.set_enabled(fits)


class OutputsView:
    """A row a digital output of the machine: whether it is on, and a button that switches it."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build it."""
        self._desk, self._controls, names = desk, controls, desk.first.interface.outputs
        self._rows: dict[str, tuple[ui.label, ui.button]] = {}
        self._on: frozenset[str] | None = None
        with ui.element("div").classes("lf-outputs"):
            for name in names:
                ui.label(name).classes("lf-name")
                shown = ui.label("-").classes("lf-number").props("role=status")
                button = theme.button(f"Switch {name} on", partial(self._switch, name))
                self._rows[name] = shown, button

    def refresh(self, shot: Snapshot | None, drives: bool) -> None:
        """Show which are on; they may be switched while the device obeys."""
        on = outputs_on(self._desk.first, shot) if shot is not None else frozenset()
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
        shot = self._desk.snapshot()
        if shot is not None:
            self._controls.switch(name, name not in outputs_on(self._desk.first, shot))


class TargetView:
    """Fields of angles and of the tip's place; what is in them is shown in the scene before the arm goes there."""

    def __init__(self, desk: Desk, controls: Controls, scene: Callable[[], ArmScene]) -> None:
        """Build it; `scene` gives the scene that shows the target."""
        self._desk, self._controls, self._scene, self._filling = desk, controls, scene, False
        self._next: Array | None = None  # place that is searched next, m
        self._searches = False
        self.angles: dict[str, ui.number] = {}
        with ui.element("div").classes("lf-fields"):
            for name, joint in desk.first.joints.items():
                half = degrees(joint.stops.working_stroke) / 2
                wrong = partial(self._wrong, name)
                field = ui.number(f"{name} (deg)", value=0.0, step=1.0, precision=2, validation=wrong)
                field.on_value_change(self._typed)
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
        self.told = ui.label("").classes("lf-told").props("role=alert")
        self.cancel = theme.button("Cancel the search", self._end_search, icon="close")
        ui.context.client.on_delete(lambda: desk.worker.forget(self))
        self.cancel.set_visibility(False)
        with ui.row().classes("lf-line"):
            self.go = theme.button("Go to target", self._go, icon="near_me", kind="primary")
            theme.button("Take present angles", self._here, icon="pin_drop")
        ui.label("Or click the green surface in the picture: places that the tip can reach.").classes(
            "lf-quiet lf-small"
        )

    async def clicked(self, place: Array) -> None:
        """Take a place that was clicked, m, (3,)."""
        for axis, at in zip(self.place, place.tolist(), strict=False):
            self.place[axis].value = round(1e3 * at, 1)
        await self._find()

    def refresh(self, fits: bool) -> None:
        """Enable what may be used."""
        self.go.set_enabled(fits and self.wanted() is not None)

    def wanted(self) -> tuple[float, ...] | None:
        """Return the target, rad; None where a field holds none that can be."""
        try:
            return target(self._desk.first, {name: number(field.value) for name, field in self.angles.items()})
        except LayflatError:
            return None

    def _wrong(self, joint: str, value: float | None) -> str | None:
        """Return what is wrong with the angle of a joint, deg."""
        try:
            target(self._desk.first, {**dict.fromkeys(self._desk.first.joints, 0.0), joint: number(value)})
        except LayflatError as error:
            return str(error)
        return None

    def _typed(self) -> None:
        if self._filling:
            return
        wanted = self.wanted()
        self._scene().target(wanted)
        if wanted is not None:
            tip = 1e3 * self._desk.inverse.tip(np.array(wanted))
            for axis, at in zip(self.place, tip.tolist(), strict=False):
                self.place[axis].value = round(at, 1)

    async def _find(self) -> None:
        """Search angles for the place in the fields; one search goes on at a time, and the newest place counts."""
        place = [number(field.value) for field in self.place.values()]
        if None in place:
            self.told.set_text("Give a number of millimetres in each field of the tip.")
            return
        self._next = 1e-3 * np.array(place, float)
        if self._searches:
            return
        self._searches = True
        self.cancel.set_visibility(True)
        try:
            while self._next is not None:
                await self._search()
        finally:
            self._searches = False
            self.cancel.set_visibility(False)

    def _end_search(self) -> None:
        self._desk.worker.cancel(self)

    async def _search(self) -> None:
        desk, shot, place, self._next = self._desk, self._desk.snapshot(), self._next, None
        near = np.array(shot["averaged_angle"] if shot is not None else np.zeros(len(self.angles)))
        self.told.set_text("searching")
        what = "the search for angles"
        try:
            call = partial(desk.worker.call, limit=LONGEST_SEARCH, what=what, by=self)
            found = await call(find_posture, desk.first, place, near)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.told.set_text("")
        if self._next is None:
            self._fill(found)

    def _fill(self, angles: Array) -> None:
        self._filling = True
        for field, angle in zip(self.angles.values(), angles.tolist(), strict=True):
            field.value = round(degrees(angle), 2)
        self._filling = False
        self._typed()

    def _here(self) -> None:
        shot = self._desk.snapshot()
        if shot is not None:
            self._fill(np.array(shot["averaged_angle"]))

    def _go(self) -> None:
        if (wanted := self.wanted()) is None:
            return  # the field says what is wrong
        try:
            self._controls.go([Step(wanted)])
        except LayflatError as error:
            self.told.set_text(str(error))
