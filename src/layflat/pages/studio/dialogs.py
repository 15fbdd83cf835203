"""Questions of the studio: under which name to save, and how runs of the cloud differ."""

from collections.abc import Awaitable, Callable
from dataclasses import replace
from math import degrees, radians
from pathlib import Path

from nicegui import ui

from layflat.errors import InputError, LayflatError
from layflat.pages.look import theme
from layflat.pages.look.dialogs import confirmed, within
from layflat.pages.studio.cloud import Tolerances
from layflat.pages.studio.saving import place
from layflat.pages.studio.session import Session

Write = Callable[[Path], Awaitable[str]]
"""Writes to a path and returns what to say of it."""


async def save_as(
    title: str, explained: str, name: str, root: Path, suffix: str, write: Write, *, warned: str = ""
) -> str:
    """Ask for a name below a folder and write there; return what was said of it, "" if nothing was written.

    Args:
        title: of the dialog.
        explained: what is written.
        name: that is suggested.
        root: the folder that nothing is written outside of.
        suffix: of the file, "" for a folder.
        write: writes it.
        warned: what to know before.
    """
    with ui.dialog() as dialog, ui.card().classes("lf-dialog").props("role=dialog aria-modal=true") as card:
        card.props["aria-label"] = title
        theme.text_element("h2", title)
        ui.label(explained)
        if warned:
            theme.note(warned, "warning")
        field = (
            ui.input(f"Name, below {root.name or root}", value=name)
            .props("outlined autofocus maxlength=1000")
            .classes("st-full")
        )
        wrong = ui.label().classes("st-wrong").props("role=alert")

        async def go() -> None:
            try:
                path = place(root, field.value or "", suffix)
                if path.exists() and not await confirmed(
                    f"{path.name} is there already. Write in its place?", "Replace"
                ):
                    return
                dialog.submit(await write(path))
            except LayflatError as error:
                wrong.set_text(_said(error))

        field.on("keydown.enter", go)
        with ui.row().classes("lf-line"):
            theme.button("Save", go, kind="primary")
            theme.button("Cancel", lambda: dialog.submit(""))
    answer = await dialog
    dialog.delete()
    return str(answer or "")


def _said(error: LayflatError) -> str:
    if isinstance(error, InputError) and error.what:
        return f"{error.what}; {error.right}" if error.right else error.what
    return str(error)


class Settings:
    """Settings of the simulated step, and of the tolerances from run to run."""

    def __init__(self, session: Session) -> None:
        """Make them within the current element."""
        self._session = session
        tolerances, step = session.tolerances, session.step
        with ui.expansion("Step and tolerances").classes("st-settings").props("dense switch-toggle-side"):
            with ui.element("div").classes("st-grid"):
                self._size = _number("Step, deg", degrees(step.size), 1, 360, self._step)
                self._lasts = _number("Time shown, s", step.lasts, 0.2, 10, self._step)
                self._shares = {
                    name: _number(label, 100 * getattr(tolerances, name), 0, most, self._vary)
                    for name, label, most in SHARES
                }
            ui.label(
                "Runs differ by so much either way; payloads go from none to this share of the described one. The "
                "controller knows the nominal machine only."
            ).classes("lf-quiet lf-small")

    def _step(self) -> None:
        step = self._session.step
        size, lasts = _read(self._size, degrees(step.size)), _read(self._lasts, step.lasts)
        self._session.look(step=replace(step, size=radians(size), lasts=lasts))

    def _vary(self) -> None:
        before = self._session.tolerances
        shares = {name: _read(field, 100 * getattr(before, name)) / 100 for name, field in self._shares.items()}
        self._session.look(tolerances=Tolerances(**shares))


SHARES = (
    ("supply", "Supply pressure, %", 50),
    ("valve", "Flow of the valve, %", 50),
    ("friction", "Torque of the brake, %", 100),
    ("losses", "Losses, %", 100),
    ("payload", "Payload up to, %", 200),
)
"""Fields of `Tolerances`, their names on the page, and the most that is allowed, per cent."""


def _number(label: str, value: float, least: float, most: float, changed: Callable[[], object]) -> ui.number:
    field = ui.number(label, value=round(value, 6), min=least, max=most, format="%.4g").props("outlined dense")
    field.on("blur", changed).on("keydown.enter", changed)
    return field.classes("st-setting")


def _read(field: ui.number, before: float) -> float:
    """Return the number in a field, inside its limits; what was there before where it holds none."""
    return within(field.value, field.min, field.max, before)
