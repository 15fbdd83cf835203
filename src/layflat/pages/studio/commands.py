"""Commands of the page's header: undo and redo, comparison, tuning, saving; and notices above the results."""

from collections.abc import Awaitable, Callable
from pathlib import Path

from nicegui import ui

from layflat import extras
from layflat.design.drawing import write_drawings
from layflat.design.summary import refuse_errors
from layflat.errors import DesignError, InputError, LayflatError, MissingExtraError
from layflat.files import write_text
from layflat.pages.look import theme
from layflat.pages.look.theme import confirm
from layflat.pages.studio.design import digest
from layflat.pages.studio.report import ReportContent, render_report
from layflat.pages.studio.saving import file_below
from layflat.pages.studio.session import StudioSession
from layflat.pages.studio.tune_view import TuneView

FILE_CHECK_PERIOD = 1.0  # of the checks whether files have changed, s
Write = Callable[[Path], Awaitable[str]]
"""Function that writes to a path and returns a message about it."""


class KeptView:
    """Notice about the design that is kept as A, above the results; hidden while there is none."""

    def __init__(self, session: StudioSession, edited: Callable[[], object]) -> None:
        """Make it within the current element; `edited` is called when the design has become A again."""
        self._session, self._edited = session, edited
        with ui.element("div").classes("lf-note st-line") as self._box:
            ui.icon("push_pin").props("aria-hidden=true")
            self._text = ui.label().classes("st-grow")
            self._return = theme.button("Return", self._restore_kept, hint="Return to A: an edit that can be undone")
            theme.button("Drop", session.drop, kind="flat", hint="Drop A: compare no more")
        self.refresh()

    def refresh(self) -> None:
        """Show when A was kept and how it was changed."""
        kept = self._session.kept
        self._box.set_visibility(kept is not None)
        if kept is not None:
            changed = len(kept.changes)
            count = f"{changed} value{'s' * (changed != 1)} changed" if changed else "as opened"
            self._text.set_text(f"Red and dashed: A, kept at {kept.since}, {count}.")
            self._return.set_enabled(kept.changes != self._session.design.changes)

    def _restore_kept(self) -> None:
        """Replace the changes of the design by those of the kept design A, as one edit; show an error as a message."""
        kept = self._session.kept
        if kept is None:
            return
        try:
            self._session.design.replace_all(kept.changes)
        except LayflatError as error:
            theme.show_message(str(error), "danger")
            return
        self._edited()


class DiskView:
    """Notice that a file of the description has changed on disk, above the results; hidden otherwise."""

    def __init__(self, session: StudioSession, reread: Callable[[], Awaitable[None]]) -> None:
        """Make it within the current element; `reread` is called when the files were read again."""
        self._session, self._reread = session, reread
        self._dismissed: tuple[str, ...] = ()  # changes for which the notice was dismissed
        self._changed: tuple[str, ...] = ()
        with ui.element("div").classes("lf-note lf-warning st-line").props("role=alert") as self._box:
            ui.icon("warning").props("aria-hidden=true")
            self._text = ui.label().classes("st-grow")
            theme.button("Reload, keep my changes", self._reload)
            theme.button("Go on without", self._go_on, kind="flat")
        self._box.set_visibility(False)
        if session.design.opened.files:
            ui.timer(FILE_CHECK_PERIOD, self._check_files)

    def _check_files(self) -> None:
        """Show the notice if a file has changed on disk since it was opened, unless this change was dismissed."""
        opened = self._session.design.opened
        changed = opened.changed_on_disk()
        self._changed = tuple(f"{path}: {digest(path)}" for path in changed)
        self._box.set_visibility(bool(changed) and self._changed != self._dismissed)
        if changed:
            names = " and ".join(path.name for path in changed)
            self._text.set_text(f"{names} has changed on the disk since it was opened.")

    async def _reload(self) -> None:
        """Reopen the changed files and name the changes that do not fit them any more."""
        with theme.show_errors_on(self._text):
            dropped = await self._session.reload()
            self._box.set_visibility(False)
            if dropped:
                text = f"These changes do not go with the file any more and were dropped: {', '.join(dropped)}"
                theme.show_message(text, "warning", stays=True)
            await self._reread()

    def _go_on(self) -> None:
        """Hide the notice until a file changes again."""
        self._dismissed = self._changed
        self._box.set_visibility(False)


async def save_as(
    title: str, explained: str, name: str, root: Path, suffix: str, write: Write, *, warned: str = ""
) -> str:
    """Ask for a name below a folder and write there; return the message of `write`, "" if nothing was written.

    A question precedes the replacement of an existing file, and errors are shown in the dialog, which stays open.

    Args:
        title: title of the dialog.
        explained: explanation of what is written.
        name: suggested name.
        root: folder that nothing is written outside of.
        suffix: suffix of the file, "" for a folder.
        write: writes to the chosen path.
        warned: warning that is shown before.
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
            """Write to the entered name and close the dialog; show an error in it instead."""
            try:
                path = file_below(root, field.value or "", suffix)
                if path.exists() and not await confirm(f"{path.name} is there already. Write in its place?", "Replace"):
                    return
                dialog.submit(await write(path))
            except LayflatError as error:
                wrong.set_text(_error_text(error))

        field.on("keydown.enter", go)
        with ui.row().classes("lf-line"):
            theme.button("Save", go, kind="primary")
            theme.button("Cancel", lambda: dialog.submit(""))
    answer = await dialog
    theme.remove_dialog(dialog)
    return str(answer or "")


def _error_text(error: LayflatError) -> str:
    """Return the message of an error, without the place of an InputError."""
    if isinstance(error, InputError) and error.what:
        return f"{error.what}; {error.right}" if error.right else error.what
    return str(error)


class Commands:
    """Buttons of the commands on the whole design."""

    def __init__(self, session: StudioSession, folder: Path, edited: Callable[[], object]) -> None:
        """Make the commands; `build` adds their buttons to the page."""
        self._session, self._folder, self._edited = session, folder, edited
        self.tune = TuneView(session)
        self._asking = False

    @property
    def has_open_dialog(self) -> bool:
        """True while a dialog is open, which then takes the keys."""
        return self._asking or bool(self.tune.dialog.value)

    def build(self) -> None:
        """Make the buttons within the current element."""

        def add_button(text: str, act: Callable[[], object], icon: str, hint: str = "") -> ui.button:
            return theme.button(text, act, icon=icon, kind="header", hint=hint).props("dense")

        self._undo = add_button("", self.undo, "undo", "Undo (Ctrl-Z)")
        self._redo = add_button("", self.redo, "redo", "Redo (Ctrl-Shift-Z)")
        add_button("Keep as A", self._session.keep_as_a, "push_pin", "Keep as A, to compare with")
        add_button("Tune", self.tune.open, "auto_fix_high", "Tune the gains")
        add_button("Save", self._save_description, "save", "Save as a description")
        add_button("Drawings", self._save_drawings, "architecture", "Drawings of the cam: DXF, SVG, CSV")
        add_button("Report", self._save_report, "description", "Report as a page")
        self.refresh()

    def refresh(self) -> None:
        """Enable the buttons of undo and redo."""
        design = self._session.design
        self._undo.set_enabled(design.can_undo)
        self._redo.set_enabled(design.can_redo)

    def undo(self) -> None:
        """Undo the last edit."""
        if self._session.design.can_undo:
            self._session.design.undo()
            self._edited()

    def redo(self) -> None:
        """Redo the edit that was undone last."""
        if self._session.design.can_redo:
            self._session.design.redo()
            self._edited()

    async def _save_description(self) -> None:
        """Ask for a file name and save the design as a description in the folder of results."""
        design = self._session.design
        own_file = design.opened.file
        explained = "Writes what differs from what was opened, as a description that extends it."
        if own_file is not None:
            explained += f" Under its own name, {own_file.stem}, the file is written anew, without its comments."

        async def write(path: Path) -> str:
            await self._session.save(path)
            return f"wrote {path.relative_to(self._folder.resolve())}"

        await self._ask_file_name("Save as a description", explained, f"{design.machine.name}-edited", ".toml", write)

    async def _save_report(self) -> None:
        """Ask for a file name and write the report of the design as an HTML page."""
        session = self._session

        async def write(path: Path) -> str:
            """Render and write the report; return a message with its path."""
            text = await self._session.worker.perform(
                render_report, ReportContent.from_session(session), what="the report"
            )
            return f"wrote {write_text(path, text).relative_to(self._folder.resolve())}"

        explained = "Writes changes, figures and pictures of the joint that is shown, as one page."
        await self._ask_file_name(
            "Report", explained, f"{session.design.machine.name}-report", ".html", write, rules=False
        )

    async def _save_drawings(self) -> None:
        """Ask for the name of a folder and write the drawings of the shown joint to it; without the extra, no DXF."""
        session = self._session
        figures = session.shown.figures
        design = None if figures is None else figures.design
        missing = ""
        try:
            extras.require("drawing", where="no DXF")
        except MissingExtraError as error:
            missing = str(error)

        async def write(path: Path) -> str:
            """Write the drawings to a folder; return a message, or raise DesignError without a design."""
            if design is None:
                raise DesignError("can't be drawn", where=session.step.joint, right="the design rules say why")
            written = await self._session.worker.perform(write_drawings, design, path, what="the drawing")
            return f"wrote {len(written)} drawings to {path.relative_to(self._folder.resolve())}"

        explained = "Writes the cam as DXF, SVG and CSV, and the layout as SVG, to a folder of this name."
        await self._ask_file_name(
            "Drawings", explained, f"{session.design.machine.name}-drawings", "", write, warned=missing
        )

    async def _ask_file_name(
        self, title: str, explained: str, name: str, suffix: str, write: Write,
        *, warned: str = "", rules: bool = True,
    ) -> None:  # fmt: skip
        """Ask for a file name and call `write` with the path; show the message that it returns.

        Args:
            title: title of the dialog.
            explained: line that explains the content of the file.
            name: proposed name, without suffix.
            suffix: suffix of the file, empty for a folder.
            write: writes to a path and returns a message for the person.
            warned: warning in the dialog.
            rules: whether violated design rules are a warning, where there is no other.
        """
        if rules and not warned:
            warned = self._design_error()
        self._asking = True
        try:
            message = await save_as(title, explained, name, self._folder, suffix, write, warned=warned)
        finally:
            self._asking = False
        if message:
            theme.show_message(message)

    def _design_error(self) -> str:
        """Return a warning with the error by which `layflat machine check` would refuse the design; "" without one."""
        try:
            refuse_errors(self._session.findings)
        except DesignError as error:
            return f"layflat machine check will refuse this design: {error}"
        return ""
