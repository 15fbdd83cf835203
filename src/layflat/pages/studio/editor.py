"""All values of the description: sections that are filled when they are opened, a search, and what was changed."""

from collections.abc import Awaitable, Callable

from nicegui import background_tasks, ui

from layflat.pages.look.pieces import Pieces
from layflat.pages.studio.design import Design
from layflat.pages.studio.field import Field, place_of, titled
from layflat.pages.studio.row import Row

MOST = 40  # values that a search shows


class Section:
    """Values of one part, made when they are first looked at."""

    def __init__(self, title: str, fields: list[Field], fill: Callable[[list[Field]], Awaitable[None]]) -> None:
        self.paths = {field.path for field in fields}
        self._fields, self._fill, self._filled = fields, fill, False
        self.box = ui.expansion(title, on_value_change=self._opened).classes("st-section")
        self.box.props("dense dense-toggle switch-toggle-side")

    def open(self) -> None:
        """Open it."""
        self.box.open()

    def mark(self, changed: int) -> None:
        """Show how many of its values were changed."""
        _caption(self.box, changed)

    def _opened(self) -> None:
        if self.box.value and not self._filled:
            self._filled = True
            background_tasks.create(self._fill(self._fields), context=self.box)


class Group:
    """Sections of a joint, or of the machine besides."""

    def __init__(self, title: str) -> None:
        self.sections: dict[str, Section] = {}
        self.box = ui.expansion(title).classes("st-group").props("dense switch-toggle-side")

    def add(self, path: str, fields: list[Field], fill: Callable[[list[Field]], Awaitable[None]]) -> None:
        """Add the section of a part."""
        with self.box:
            self.sections[path] = Section(_title(path), fields, fill)

    def mark(self, design: Design) -> None:
        """Show how many values were changed in it and in each of its sections."""
        total = 0
        for section in self.sections.values():
            changed = len(section.paths & design.changes.keys())
            section.mark(changed)
            total += changed
        _caption(self.box, total)


class Editor:
    """The left side of the page."""

    def __init__(self, design: Design, edited: Callable[[], object]) -> None:
        """Make it within the current element; `edited` is called after each edit that was taken."""
        self.design, self._edited = design, edited
        self._rows: list[Row] = []
        self._found: list[Row] = []
        self._looked = 0  # which search is the newest
        with ui.element("div").classes("st-search"):
            self._search = ui.input(placeholder="Search values", on_change=self._look).classes("st-find")
            self._search.props('outlined dense clearable maxlength=200 aria-label="Search values of the description"')
            with self._search.add_slot("prepend"):
                ui.icon("search").props("aria-hidden=true")
            self._only = ui.checkbox("changed only", on_change=self._look).props("dense")
        self._results = ui.element("div").classes("st-results")
        self._results.set_visibility(False)
        self._tree = ui.element("div").classes("st-tree")
        self._groups: dict[str, Group] = {}

    async def build(self) -> None:
        """Make all sections, piece by piece."""
        pieces = Pieces()
        sections: dict[str, dict[str, list[Field]]] = {}
        for field in self.design.fields:
            keys = field.section.split(".")
            part = ".".join(keys[:2]) if keys[0] == "joint" else ""
            sections.setdefault(part, {}).setdefault(field.section, []).append(field)
        for path in sorted(sections, key=lambda one: not one):
            with self._tree:
                group = Group(f"Joint {path.partition('.')[2]}" if path else "Machine")
            for section, fields in sections[path].items():
                group.add(section, fields, self._fill)
                await pieces.pause()
            self._groups[path] = group

    async def rebuild(self) -> None:
        """Make everything anew: the description was read again."""
        self._rows, self._found, self._groups = [], [], {}
        self._tree.clear()
        self._results.clear()
        await self.build()
        self._look()
        self.refresh()

    def look_at(self, joint: str) -> None:
        """Open the group of a joint, its hose first, and close those of other joints."""
        for path, group in self._groups.items():
            if path:
                group.box.set_value(path == f"joint.{joint}")
        chosen = self._groups.get(f"joint.{joint}")
        hose = None if chosen is None else chosen.sections.get(f"joint.{joint}.hose")
        if hose is not None:
            hose.open()

    def refresh(self) -> None:
        """Bring all values that are on the page up to date."""
        for row in (*self._rows, *self._found):
            row.refresh()
        for group in self._groups.values():
            group.mark(self.design)
        if self._only.value and {row.field.path for row in self._found} != self._matching():
            self._look()

    def reset_typed(self) -> bool:
        """Take back what was typed and not taken yet; return whether there was any."""
        dirty = [row for row in (*self._rows, *self._found) if row.dirty]
        for row in dirty:
            row.reset()
        return bool(dirty)

    async def _fill(self, fields: list[Field]) -> None:
        """Make the rows of a section, piece by piece, as long as it is there."""
        pieces, rows = Pieces(), self._rows
        await pieces.turn()
        for field in fields:
            rows.append(Row(self.design, field, self._edited))
            await pieces.pause()
            if rows is not self._rows:
                return

    def _matching(self) -> set[str]:
        words = (self._search.value or "").lower().split()
        return {
            field.path
            for field in self.design.fields
            if all(word in _words(field) for word in words)
            and (not self._only.value or field.path in self.design.changes)
        }

    def _look(self) -> None:
        looking = bool((self._search.value or "").strip()) or bool(self._only.value)
        self._tree.set_visibility(not looking)
        self._results.set_visibility(looking)
        self._results.clear()
        self._found = []
        self._looked += 1
        if looking:
            background_tasks.create(self._show_matching(self._looked), context=self._results)

    async def _show_matching(self, look: int) -> None:
        """Show the values that are searched; a newer search ends this one."""
        pieces, matching = Pieces(), self._matching()
        await pieces.turn()
        found = [field for field in self.design.fields if field.path in matching]
        if not found:
            ui.label("No value of this name." if self._search.value else "Nothing was changed.").classes("lf-quiet")
        for field in found[:MOST]:
            await pieces.pause()
            if look != self._looked:
                return
            self._found.append(Row(self.design, field, self._edited, place=True))
        if len(found) > MOST:
            ui.label(f"{len(found) - MOST} more; search for another word as well.").classes("lf-quiet")


def _caption(box: ui.expansion, changed: int) -> None:
    text = f"{changed} changed" if changed else ""
    if box.props.get("caption", "") != text:  # the page is told of every property that is set
        box.props["caption"] = text


def _title(section: str) -> str:
    if not section:
        return "Title"
    keys = section.split(".")
    if keys[0] == "joint":
        return "General" if len(keys) == 2 else titled(keys[-1])
    return place_of(section)


def _words(field: Field) -> str:
    return (
        f"{field.path} {field.path.replace('_', ' ')} {place_of(field.section)} {field.label} {field.meaning}".lower()
    )
