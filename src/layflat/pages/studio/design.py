"""A design that is being edited: what differs from the description that was opened, checked as a file, with undo."""

from collections import deque
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from layflat.description.change import value_at
from layflat.description.provenance import Provenance, Sources
from layflat.description.tables import Plain
from layflat.errors import InputError
from layflat.machine.model import Machine, build
from layflat.pages.studio.field import Field
from layflat.pages.studio.fields import fields_of
from layflat.pages.studio.opened import Opened, open_description

MOST_UNDONE = 200  # edits that can be taken back

BY_HAND = Provenance()


@dataclass(frozen=True)
class Change:
    """A value in place of the one that was opened, as it stands in a file."""

    value: Any
    source: Provenance = BY_HAND


Changes = Mapping[str, Change]


class Design:
    """A machine that a person edits. Every edit is checked as a file is; one that is refused changes nothing."""

    def __init__(self, opened: Opened) -> None:
        """Begin with a description, from `open_description`."""
        self.opened = opened
        self._past: deque[Changes] = deque(maxlen=MOST_UNDONE)
        self._future: list[Changes] = []
        self._held = ""  # path of an edit that goes on
        self._fields: list[Field] | None = None  # of the machine as it is now, once they were asked for
        self._set({}, opened.machine, opened.plain)

    @property
    def changes(self) -> Changes:
        """Return what differs from what was opened, by dotted path."""
        return self._changes

    @property
    def machine(self) -> Machine:
        """The machine as it is now."""
        return self._machine

    @property
    def plain(self) -> Plain:
        """Values as they would stand in a complete file."""
        return self._plain

    @property
    def fields(self) -> list[Field]:
        """Every value of it, in order."""
        if self._fields is None:
            self._fields = fields_of(self._machine, self._plain)
        return self._fields

    def value(self, path: str) -> Any:
        """Return what stands at a path, SI."""
        return value_at(self._machine, path)

    def was(self, path: str) -> Any:
        """Return what stood there when it was opened, SI."""
        return value_at(self.opened.machine, path)

    def source(self, path: str) -> Provenance:
        """Return where the value at a path comes from: "edited", "default" or one of `SOURCES`."""
        if path in self._changes:
            change = self._changes[path]
            return Provenance("edited") if change.source == BY_HAND else change.source
        return self.opened.sources.get(whole_path(self.opened.plain, path), Provenance("default"))

    def edit(self, path: str, value: Any, *, going_on: bool = False) -> None:
        """Put another value at a path, as it stands in a file.

        Args:
            path: of the value.
            value: text with a unit, number or truth.
            going_on: the next such edit of the path belongs to this one, and both are undone together; see `hold`.

        Raises:
            InputError: it can't stand there; everything stays as it is.
        """
        self._do({**self._changes, path: Change(value)}, held=path if going_on else "")

    def edit_all(self, changes: Changes) -> None:
        """Put several values in place at once, as one edit (InputError: one can't stand there; nothing changes)."""
        self._do({**self._changes, **changes})

    def replace_all(self, changes: Changes) -> None:
        """Put all changes in place of those that there are, as one edit (InputError: nothing changes)."""
        self._do(dict(changes))

    def back(self, path: str) -> None:
        """Bring one value back to what it was (InputError: it does not go with the others any more)."""
        self._do({key: change for key, change in self._changes.items() if key != path})

    def hold(self) -> None:
        """End an edit that goes on: the next one is undone by itself."""
        self._held = ""

    @property
    def can_undo(self) -> bool:
        """True if there is something to take back."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """True if something was taken back."""
        return bool(self._future)

    def undo(self) -> None:
        """Take back the last edit, if there is one."""
        if self._past:
            self._future.append(self._changes)
            self._show(self._past.pop())

    def redo(self) -> None:
        """Do again what was taken back last, if there is something."""
        if self._future:
            self._past.append(self._changes)
            self._show(self._future.pop())

    def reload(self) -> list[str]:
        """Read the description again and lay the changes over it.

        Returns:
            Paths of changes that do not go with it any more and were dropped.

        Raises:
            InputError: it can't be read; everything stays as it is.
        """
        opened = open_description(self.opened.given)
        kept: dict[str, Change] = {}
        for path, change in self._changes.items():
            try:
                _built(opened, {**kept, path: change})
            except InputError:
                continue
            kept[path] = change
        dropped = [path for path in self._changes if path not in kept]
        self.opened = opened
        self._past.clear()
        self._future.clear()
        self._set(kept, *_built(opened, kept))
        return dropped

    def become(self, other: "Design") -> None:
        """Take over the state of another design: the same one, after work in another process."""
        self.__dict__.update(other.__dict__)

    def _do(self, changes: Changes, *, held: str = "") -> None:
        machine, plain = _built(self.opened, changes)
        left = {path: one for path, one in changes.items() if _differs(machine, self.opened.machine, path)}
        if machine == self._machine:
            return
        if not (held and held == self._held):
            self._past.append(self._changes)
        self._future.clear()
        self._held = held
        self._set(left, machine, plain)

    def _show(self, changes: Changes) -> None:
        self._held = ""
        self._set(changes, *_built(self.opened, changes))

    def _set(self, changes: Changes, machine: Machine, plain: Plain) -> None:
        self._changes, self._machine, self._plain = changes, machine, plain
        self._fields = None


def sources_of(opened: Opened, changes: Changes) -> Sources:
    """Return the sources of all values of a description with changes."""
    return {**opened.sources, **{whole_path(opened.plain, path): one.source for path, one in changes.items()}}


def whole_path(plain: Plain, path: str) -> str:
    """Return the path of the list that a path leads into, which files give as a whole; any other path as it is."""
    table: Any = plain
    keys = path.split(".")
    for i, key in enumerate(keys):
        if isinstance(table, list):
            return ".".join(keys[:i])
        table = table.get(key) if isinstance(table, dict) else None
    return path


def put(tables: Plain, path: str, value: Any) -> None:
    """Put a value into nested tables and lists; tables that are missing on the way are made."""
    *keys, last = path.split(".")
    table: Any = tables
    for key in keys:
        table = table[int(key)] if isinstance(table, list) else table.setdefault(key, {})
    table[int(last) if isinstance(table, list) else last] = value


def _built(opened: Opened, changes: Changes) -> tuple[Machine, Plain]:
    plain = deepcopy(opened.plain)
    for path, change in changes.items():
        put(plain, path, change.value)
    return build(plain, sources_of(opened, changes), opened.given), plain


def _differs(machine: Machine, other: Machine, path: str) -> bool:
    try:
        return bool(value_at(machine, path) != value_at(other, path))
    except InputError:  # a part that is there in one of them only
        return True


def message(error: InputError, path: str) -> str:
    """Return what the checks say of a value, for a field that shows its path already."""
    text = f"{error.what}; {error.right}" if error.right else error.what
    place = error.where.rpartition(": ")[2]
    return text if not place or place == path else f"{place}: {text}"
