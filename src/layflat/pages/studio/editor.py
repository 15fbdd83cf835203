"""Editor of all values of a description: sections that are filled when they are opened, a search, a list of changes."""

from collections.abc import Awaitable, Callable

from nicegui import background_tasks, ui

from layflat.pages.look.pieces import Pieces
from layflat.pages.studio.design import Design
from layflat.pages.studio.field import Field, key_title, section_name
from layflat.pages.studio.row import Row

MAX_MATCHES = 40  # values that a search lists


class EditorSection:
    """Section of the editor with the values of one part; its rows are made when it is first opened."""

    def __init__(self, title: str, fields: list[Field], fill: Callable[[list[Field]], Awaitable[None]]) -> None:
        """Make the closed section within the current element, without rows."""
        self.paths = {field.path for field in fields}
        self._fields, self._fill, self._filled = fields, fill, False
        self.box = ui.expansion(title, on_value_change=self._opened).classes("st-section")
        self.box.props("dense dense-toggle switch-toggle-side")

    def open(self) -> None:
        """Open the section."""
        self.box.open()

    def mark(self, changed: int) -> None:
        """Show the number of changed values."""
        _caption(self.box, changed)

    def _opened(self) -> None:
        """Start to make the rows when the section is opened for the first time."""
        if self.box.value and not self._filled:
            self._filled = True
            background_tasks.create(self._fill(self._fields), context=self.box)


class EditorGroup:
    """Group of the sections of a joint, or of the rest of the machine."""

    def __init__(self, title: str) -> None:
        self.sections: dict[str, EditorSection] = {}
        self.box = ui.expansion(title).classes("st-group").props("dense switch-toggle-side")

    def add(self, path: str, fields: list[Field], fill: Callable[[list[Field]], Awaitable[None]]) -> None:
        """Add the section of a part.

        Args:
            path: path of the part.
            fields: its values.
            fill: makes the rows of values, once the section is opened.
        """
        with self.box:
            self.sections[path] = EditorSection(_section_title(path), fields, fill)

    def mark(self, design: Design) -> None:
        """Show the numbers of changed values in the group and in each of its sections."""
        total = 0
        for section in self.sections.values():
            changed = len(section.paths & design.changes.keys())
            section.mark(changed)
            total += changed
        _caption(self.box, total)


class Editor:
    """Editor of a description, on the left side of the page."""

    def __init__(self, design: Design, edited: Callable[[], object]) -> None:
        """Make it within the current element; `edited` is called after each edit that was accepted."""
        self.design, self._edited = design, edited
        self._rows: list[Row] = []
        self._matches: list[Row] = []
        self._search_count = 0  # which search is the newest
        with ui.element("div").classes("st-search"):
            self._search = ui.input(placeholder="Search values", on_change=self._start_search).classes("st-find")
            self._search.props('outlined dense clearable maxlength=200 aria-label="Search values of the description"')
            with self._search.add_slot("prepend"):
                ui.icon("search").props("aria-hidden=true")
            self._only = ui.checkbox("changed only", on_change=self._start_search).props("dense")
        self._results = ui.element("div").classes("st-results")
        self._results.set_visibility(False)
        self._tree = ui.element("div").classes("st-tree")
        self._groups: dict[str, EditorGroup] = {}

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
                group = EditorGroup(f"Joint {path.partition('.')[2]}" if path else "Machine")
            for section, fields in sections[path].items():
                group.add(section, fields, self._fill_section)
                await pieces.pause()
            self._groups[path] = group

    async def rebuild(self) -> None:
        """Rebuild all sections after the description was read again."""
        self._rows, self._matches, self._groups = [], [], {}
        self._tree.clear()
        self._results.clear()
        await self.build()
        self._start_search()
        self.refresh()

    def show_joint(self, joint: str) -> None:
        """Open the group of a joint, its hose first, and close those of other joints."""
        for path, group in self._groups.items():
            if path:
                group.box.set_value(path == f"joint.{joint}")
        chosen = self._groups.get(f"joint.{joint}")
        hose = None if chosen is None else chosen.sections.get(f"joint.{joint}.hose")
        if hose is not None:
            hose.open()

    def refresh(self) -> None:
        """Update all rows and counts on the page, and repeat a search for changed values whose matches differ now."""
        for row in (*self._rows, *self._matches):
            row.refresh()
        for group in self._groups.values():
            group.mark(self.design)
        if self._only.value and {row.field.path for row in self._matches} != self._matching_paths():
            self._start_search()

    def reset_typed(self) -> bool:
        """Replace typed text that was not accepted yet by the design's values; return whether there was any."""
        dirty = [row for row in (*self._rows, *self._matches) if row.has_unaccepted_text]
        for row in dirty:
            row.reset()
        return bool(dirty)

    async def _fill_section(self, fields: list[Field]) -> None:
        """Make the rows of a section, piece by piece, until the editor is rebuilt."""
        pieces, rows = Pieces(), self._rows
        await pieces.turn()
        for field in fields:
            rows.append(Row(self.design, field, self._edited))
            await pieces.pause()
            if rows is not self._rows:
                return

    def _matching_paths(self) -> set[str]:
        """Return the paths of the fields that contain all searched words; only changed ones if the switch is on."""
        words = (self._search.value or "").lower().split()
        return {
            field.path
            for field in self.design.fields
            if all(word in _words(field) for word in words)
            and (not self._only.value or field.path in self.design.changes)
        }

    def _start_search(self) -> None:
        """Show the matching fields in place of the tree, or the tree if neither words nor switch are set."""
        looking = bool((self._search.value or "").strip()) or bool(self._only.value)
        self._tree.set_visibility(not looking)
        self._results.set_visibility(looking)
        self._results.clear()
        self._matches = []
        self._search_count += 1
        if looking:
            background_tasks.create(self._show_matching(self._search_count), context=self._results)

    async def _show_matching(self, search_number: int) -> None:
        """List the matching values; a newer search ends this one."""
        pieces, matching = Pieces(), self._matching_paths()
        await pieces.turn()
        fields = [field for field in self.design.fields if field.path in matching]
        if not fields:
            ui.label("No value of this name." if self._search.value else "Nothing was changed.").classes("lf-quiet")
        for field in fields[:MAX_MATCHES]:
            await pieces.pause()
            if search_number != self._search_count:
                return
            self._matches.append(Row(self.design, field, self._edited, place=True))
        if len(fields) > MAX_MATCHES:
            ui.label(f"{len(fields) - MAX_MATCHES} more; search for another word as well.").classes("lf-quiet")


def _caption(box: ui.expansion, changed: int) -> None:
    """Show a number of changed values below the title of an expansion; nothing for 0."""
    text = f"{changed} changed" if changed else ""
    if box.props.get("caption", "") != text:  # the page receives every property that is set
        box.props["caption"] = text


def _section_title(section: str) -> str:
    """Return the title of a section within its group."""
    if not section:
        return "Title"
    keys = section.split(".")
    if keys[0] == "joint":
        return "General" if len(keys) == 2 else key_title(keys[-1])
    return section_name(section)


def _words(field: Field) -> str:
    """Return the text in which a field is searched: path, section, label and meaning, in lower case."""
    names = f"{field.path} {field.path.replace('_', ' ')} {section_name(field.section)}"
    return f"{names} {field.label} {field.meaning}".lower()
