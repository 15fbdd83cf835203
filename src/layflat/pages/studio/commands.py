"""The buttons in the page's header: undo and redo, comparison, tuning, and what is written to the disk."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from nicegui import ui

from layflat import extras
from layflat.design.drawing import write_drawings
from layflat.design.findings import refuse_errors
from layflat.errors import DesignError, MissingExtraError
from layflat.files import write_text
from layflat.pages.look import theme
from layflat.pages.studio.beside import LIMIT, write_design
from layflat.pages.studio.dialogs import Write, save_as
from layflat.pages.studio.report import Content, report
from layflat.pages.studio.session import Session
from layflat.pages.studio.tune_view import TuneView

Result = TypeVar("Result")


class Commands:
    """Commands on the whole design."""

    def __init__(self, session: Session, folder: Path, edited: Callable[[], object]) -> None:
        """Make them; `build` puts their buttons on the page."""
        self._session, self._folder, self._edited = session, folder, edited
        self.tune = TuneView(session)
        self._asking = False

    @property
    def asking(self) -> bool:
        """True while a dialog is open, which then takes the keys."""
        return self._asking or bool(self.tune.dialog.value)

    def build(self) -> None:
        """Make the buttons within the current element."""

        def put(text: str, act: Callable[[], object], icon: str, hint: str = "") -> ui.button:
            return theme.button(text, act, icon=icon, kind="header", hint=hint).props("dense")

        self._undo = put("", self.undo, "undo", "Undo (Ctrl-Z)")
        self._redo = put("", self.redo, "redo", "Redo (Ctrl-Shift-Z)")
        put("Keep as A", self._session.keep, "push_pin", "Keep as A, to compare with")
        put("Tune", self.tune.open, "auto_fix_high", "Tune the gains")
        put("Save", self._save, "save", "Save as a description")
        put("Drawings", self._draw, "architecture", "Drawings of the cam: DXF, SVG, CSV")
        put("Report", self._report, "description", "Report as a page")
        self.refresh()

    def refresh(self) -> None:
        """Enable what can be done."""
        design = self._session.design
        self._undo.set_enabled(design.can_undo)
        self._redo.set_enabled(design.can_redo)

    def undo(self) -> None:
        """Take back the last edit."""
        if self._session.design.can_undo:
            self._session.design.undo()
            self._edited()

    def redo(self) -> None:
        """Do again what was taken back last."""
        if self._session.design.can_redo:
            self._session.design.redo()
            self._edited()

    async def _save(self) -> None:
        design = self._session.design
        own = design.opened.file
        explained = "Writes what differs from what was opened, as a description that extends it."
        if own is not None:
            explained += f" Under its own name, {own.stem}, the file is written anew, without its comments."

        async def write(path: Path) -> str:
            design.become(await self._beside(write_design, design, path, what="the saving"))
            return f"wrote {path.relative_to(self._folder.resolve())}"

        await self._ask("Save as a description", explained, f"{design.machine.name}-edited", ".toml", write)

    async def _report(self) -> None:
        session = self._session

        async def write(path: Path) -> str:
            text = await self._beside(report, Content.of(session), what="the report")
            return f"wrote {write_text(path, text).relative_to(self._folder.resolve())}"

        explained = "Writes changes, figures and pictures of the joint that is shown, as one page."
        await self._ask("Report", explained, f"{session.design.machine.name}-report", ".html", write, rules=False)

    async def _draw(self) -> None:
        session = self._session
        figures = session.shown.figures
        made = None if figures is None else figures.design
        missing = ""
        try:
            extras.require("drawing", where="no DXF")
        except MissingExtraError as error:
            missing = str(error)

        async def write(path: Path) -> str:
            if made is None:
                raise DesignError("can't be drawn", where=session.step.joint, right="the design rules say why")
            written = await self._beside(write_drawings, made, path, what="the drawing")
            return f"wrote {len(written)} drawings to {path.relative_to(self._folder.resolve())}"

        explained = "Writes the cam as DXF, SVG and CSV, and the layout as SVG, to a folder of this name."
        await self._ask("Drawings", explained, f"{session.design.machine.name}-drawings", "", write, warned=missing)

    async def _ask(
        self, title: str, explained: str, name: str, suffix: str, write: Write,
        *, warned: str = "", rules: bool = True,
    ) -> None:  # fmt: skip
        if rules and not warned:
            warned = self._refused()
        self._asking = True
        try:
            said = await save_as(title, explained, name, self._folder, suffix, write, warned=warned)
        finally:
            self._asking = False
        if said:
            theme.say(said)

    async def _beside(self, work: Callable[..., Result], *arguments: Any, what: str) -> Result:
        return await self._session.worker.beside.call(work, *arguments, limit=LIMIT, what=what)

    def _refused(self) -> str:
        """Return the error with which `layflat check` would refuse the design."""
        try:
            refuse_errors(self._session.findings)
        except DesignError as error:
            return f"layflat check will refuse this design: {error}"
        return ""
