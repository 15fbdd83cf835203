"""Design that a person edits: its differences from the opened description, checked as a file is, with undo."""

from collections import deque
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Self

from layflat.description.change import value_at
from layflat.description.tables import Plain, Provenance, Sources
from layflat.errors import InputError
from layflat.machine.loader import MACHINE_LIBRARY, load, tables
from layflat.machine.model import Machine, build
from layflat.pages.studio.field import Field, fields_of

MAX_UNDONE = 200  # edits that can be taken back
BY_HAND = Provenance()


@dataclass(frozen=True)
class OpenedDescription:
    """Description as it was read from its files."""

    name: str  # built-in name or file
    plain: Plain  # all values as they are written, those of extended descriptions included
    sources: Sources
    own_tables: Plain  # tables of its own file, sources and `extends` included
    machine: Machine
    digests: dict[str, str] = field(
        default_factory=dict
    )  # SHA-256 of its file and of the files that it extends, by path
    rewritten: bool = False  # whether its own file was saved since it was opened

    @property
    def file(self) -> Path | None:
        """The machine's own file; None of a built-in machine."""
        path = Path(self.name)
        return path.resolve() if str(path.resolve()) in self.digests else None

    @property
    def files(self) -> list[Path]:
        """The machine's file and those that it extends, as far as they are not built in."""
        return [Path(path) for path in self.digests]

    def as_rewritten(self) -> Self:
        """Return a copy that is marked as saved over its own file, with the file's present digest."""
        digests = {
            path: digest(Path(path)) if Path(path) == self.file else recorded for path, recorded in self.digests.items()
        }
        return replace(self, digests=digests, rewritten=True)

    def changed_on_disk(self) -> list[Path]:
        """Return the files that have changed or were deleted since they were read."""
        return [Path(path) for path, recorded in self.digests.items() if digest(Path(path)) != recorded]


def open_description(name: str) -> OpenedDescription:
    """Return the description of a built-in machine or a file, as read.

    Raises:
        MachineError: it is missing or wrong.
    """
    load(name)  # raises the usual errors
    digests = {
        str(path.resolve()): digest(path)
        for path in (
            Path(layer.where) for layer in MACHINE_LIBRARY.layers(name) if layer.where not in MACHINE_LIBRARY.names
        )
        if path.is_file()
    }
    plain, sources = tables(name)
    own_tables = MACHINE_LIBRARY.raw(name) if str(Path(name).resolve()) in digests else {}
    return OpenedDescription(name, plain, sources, own_tables, build(plain, sources, name), digests)


def digest(path: Path) -> str:
    """Return the SHA-256 of a file's content; "" if the file was deleted."""
    try:
        return sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


@dataclass(frozen=True)
class Change:
    """Value in place of the opened one, as a file holds it, with its source."""

    value: Any
    source: Provenance = BY_HAND


Changes = Mapping[str, Change]


class Design:
    """Machine that a person edits. Every edit is checked as a file is; one that is refused changes nothing.

    Attributes:
        changes: differences from the opened description, by dotted path.
        machine: present machine.
        plain: its values as a complete file holds them.
    """

    changes: Changes
    machine: Machine
    plain: Plain

    def __init__(self, opened: OpenedDescription) -> None:
        """Begin with a description, from `open_description`."""
        self.opened = opened
        self._past: deque[Changes] = deque(maxlen=MAX_UNDONE)
        self._future: list[Changes] = []
        self._held = ""  # path of an edit that may go on
        self._fields: list[Field] | None = None  # of the present machine, once computed
        self._set({}, opened.machine, opened.plain)

    @property
    def fields(self) -> list[Field]:
        """All values of the machine, in the order of a description."""
        if self._fields is None:
            self._fields = fields_of(self.machine, self.plain)
        return self._fields

    def value(self, path: str) -> Any:
        """Return the value at a path, SI."""
        return value_at(self.machine, path)

    def opened_value(self, path: str) -> Any:
        """Return the opened description's value at a path, SI."""
        return value_at(self.opened.machine, path)

    def source(self, path: str) -> Provenance:
        """Return the source of the value at a path: "edited", "default" or one of `SOURCES`."""
        if path in self.changes:
            change = self.changes[path]
            return Provenance("edited") if change.source == BY_HAND else change.source
        return self.opened.sources.get(whole_path(self.opened.plain, path), Provenance("default"))

    def edit(self, path: str, value: Any, *, going_on: bool = False) -> None:
        """Replace the value at a path and add an undo step, unless the machine stays the same.

        Args:
            path: dotted path of the value.
            value: text with a unit, number or boolean, as a file holds it.
            going_on: whether the next such edit of the path joins this one, to be undone together; see `hold`.

        Raises:
            InputError: the value is refused; nothing changes.
        """
        self._apply({**self.changes, path: Change(value)}, held=path if going_on else "")

    def edit_all(self, changes: Changes) -> None:
        """Replace several values as one edit (InputError: one of them is refused; nothing changes)."""
        self._apply({**self.changes, **changes})

    def replace_all(self, changes: Changes) -> None:
        """Replace all present changes as one edit (InputError: they are refused; nothing changes)."""
        self._apply(dict(changes))

    def revert(self, path: str) -> None:
        """Revert one value to the opened one, as an edit.

        Raises:
            InputError: it is refused together with the other changes; nothing changes.
        """
        self._apply({key: change for key, change in self.changes.items() if key != path})

    def hold(self) -> None:
        """End an edit that may go on: the next edit is an undo step of its own."""
        self._held = ""

    @property
    def can_undo(self) -> bool:
        """True if there is an edit to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """True if there is an edit to redo."""
        return bool(self._future)

    def undo(self) -> None:
        """Undo the last edit, if there is one."""
        if self._past:
            self._future.append(self.changes)
            self._show(self._past.pop())

    def redo(self) -> None:
        """Redo the edit that was undone last, if there is one."""
        if self._future:
            self._past.append(self.changes)
            self._show(self._future.pop())

    def reload(self) -> list[str]:
        """Read the description again and overlay the changes; there is nothing to undo or redo after that.

        Returns:
            Paths of changes that are refused now and were dropped.

        Raises:
            InputError: the description can't be read; nothing changes.
        """
        opened = open_description(self.opened.name)
        kept: dict[str, Change] = {}
        for path, change in self.changes.items():
            try:
                _build_changed(opened, {**kept, path: change})
            except InputError:
                continue
            kept[path] = change
        dropped = [path for path in self.changes if path not in kept]
        self.opened = opened
        self._past.clear()
        self._future.clear()
        self._set(kept, *_build_changed(opened, kept))
        return dropped

    def become(self, other: "Design") -> None:
        """Adopt the state of another design: the same one, after work in another process."""
        self.__dict__.update(other.__dict__)

    def _apply(self, changes: Changes, *, held: str = "") -> None:
        """Set the changes of the design and add an undo step, unless the edit of the path `held` goes on.

        Changes that equal the opened values are dropped. Nothing happens if the machine stays the same.

        Raises:
            InputError: the changes are refused.
        """
        machine, plain = _build_changed(self.opened, changes)
        effective = {path: one for path, one in changes.items() if _differs(machine, self.opened.machine, path)}
        if machine == self.machine:
            return
        if not (held and held == self._held):
            self._past.append(self.changes)
        self._future.clear()
        self._held = held
        self._set(effective, machine, plain)

    def _show(self, changes: Changes) -> None:
        """Set changes that were accepted before, without an undo step."""
        self._held = ""
        self._set(changes, *_build_changed(self.opened, changes))

    def _set(self, changes: Changes, machine: Machine, plain: Plain) -> None:
        self.changes, self.machine, self.plain = changes, machine, plain
        self._fields = None


def sources_of(opened: OpenedDescription, changes: Changes) -> Sources:
    """Return the sources of all values of a description, those of changed values replaced, by path."""
    return {**opened.sources, **{whole_path(opened.plain, path): one.source for path, one in changes.items()}}


def whole_path(plain: Plain, path: str) -> str:
    """Return the path of the list that a path leads into, as files hold whole lists; any other path as it is."""
    table: Any = plain
    keys = path.split(".")
    for i, key in enumerate(keys):
        if isinstance(table, list):
            return ".".join(keys[:i])
        table = table.get(key) if isinstance(table, dict) else None
    return path


def set_at_path(tables: Plain, path: str, value: Any) -> None:
    """Set a value in nested tables and lists; missing tables on the path are created.

    Args:
        tables: nested tables, changed in place.
        path: dotted path; an item of a list by its index.
        value: value as a file holds it.
    """
    *keys, last = path.split(".")
    table: Any = tables
    for key in keys:
        table = table[int(key)] if isinstance(table, list) else table.setdefault(key, {})
    table[int(last) if isinstance(table, list) else last] = value


def _build_changed(opened: OpenedDescription, changes: Changes) -> tuple[Machine, Plain]:
    """Return the machine of an opened description with changes, and its tables; raise InputError if it is refused."""
    plain = deepcopy(opened.plain)
    for path, change in changes.items():
        set_at_path(plain, path, change.value)
    return build(plain, sources_of(opened, changes), opened.name), plain


def _differs(machine: Machine, other: Machine, path: str) -> bool:
    """Return whether two machines differ in the value at a path, or only one of them has it."""
    try:
        return bool(value_at(machine, path) != value_at(other, path))
    except InputError:  # a part that only one of them has
        return True


def error_text(error: InputError, path: str) -> str:
    """Return the message of an error about a value, without its path, for a field that shows the path already."""
    text = f"{error.what}; {error.right}" if error.right else error.what
    place = error.where.rpartition(": ")[2]
    return text if not place or place == path else f"{place}: {text}"
