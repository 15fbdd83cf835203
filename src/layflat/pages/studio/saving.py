"""Saving of results, and of a description that says only what differs from the opened one."""

import os
import re
import tempfile
from copy import deepcopy
from pathlib import Path
from typing import Any

from layflat.description.names import file_name
from layflat.description.tables import Plain
from layflat.design.findings import Finding
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine.cloud import parted
from layflat.machine.listing import at_path, to_toml
from layflat.machine.loader import MACHINES, load
from layflat.machine.stale import counted_twice, stale_values
from layflat.pages.studio.design import Design, put, sources_of, whole_path

WHERE = "name"
RIGHT = 'give a name such as "my-arm", or "designs/my-arm" for a subfolder'


def place(root: Path, name: str, suffix: str) -> Path:
    """Return the file of a name below a folder.

    Args:
        root: the folder that nothing is written outside of.
        name: of the file, with or without its suffix, and of subfolders before it.
        suffix: such as ".toml"; "" for a folder.

    Raises:
        InputError: it is no name, or leads out of the folder.
    """
    text = name.strip()
    if text.startswith(("/", "~")) or "\\" in text or re.match(r"[A-Za-z]:", text):
        raise InputError(f"{text!r} is not below the folder that the studio was started in", where=WHERE, right=RIGHT)
    parts = text.split("/")
    if not parts[-1].endswith(suffix):
        parts[-1] += suffix
    for part in parts:
        file_name(part.removesuffix(suffix) if part is parts[-1] and suffix else part, WHERE)
    path = root.resolve().joinpath(*parts)
    if not path.parent.resolve().is_relative_to(root.resolve()) or path.is_symlink():
        raise InputError(f"{text!r} leads out of the folder by a link", where=WHERE, right="give another name")
    if suffix and path.is_dir():
        raise InputError(f"{text!r} is a folder", where=WHERE, right="give another name")
    return path


def refuse_base(design: Design, path: Path) -> None:
    """Raise InputError if a path is a file that the design's own file extends: it would extend itself."""
    opened = design.opened
    if path.resolve() in opened.files and path.resolve() != opened.file:
        raise InputError(f"{path.name!r} is what this design extends", where=WHERE, right="give another name")


def save(design: Design, path: Path) -> Path:
    """Write the design as a description, in place of what is there, and return its path.

    It extends what was opened and says only what differs. Over its own file it says what that said, with the changes.
    If what was opened is not the same on disk any more, the file is complete instead.

    Raises:
        InputError: it would overwrite what it extends, or what was written is not the design.
        OutputError: it can't be written there.
    """
    refuse_base(design, path)
    own = path.resolve() == design.opened.file
    with whole_file(path) as temporary:
        temporary.write_text(_text(design, path), encoding="utf-8")
        if load(str(temporary)).model_copy(update={"name": design.machine.name}) != design.machine:
            right = "reload what was opened, or give another name"
            raise InputError("can't be saved: what it extends is not as it was opened", where=str(path), right=right)
    if own:
        design.opened = design.opened.as_rewritten()
    return path


def stale(design: Design) -> list[Finding]:
    """Return what `layflat check` would say of values that were given for other sizes than the design has."""
    if not design.changes:
        return []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "design.toml"
        path.write_text(_text(design, path), encoding="utf-8")
        machine = load(str(path))
        found = [("stale", one) for one in stale_values(machine)] + [("volume", one) for one in counted_twice(machine)]
    return [
        Finding("warning" if rule == "stale" else "note", rule, one.path, one.what, one.right) for rule, one in found
    ]


def _text(design: Design, path: Path) -> str:
    opened, changes = design.opened, design.changes
    sources = sources_of(opened, changes)
    if path.resolve() == opened.file:
        own = deepcopy(opened.own)
        for key, value, source in _differences(design):
            put(own, key, value if source is None else {"value": value, **source})
        return to_toml(own, {})
    if opened.rewritten or opened.changed_on_disk():
        return to_toml({**design.plain, "name": path.stem}, sources)
    tables: Plain = {"extends": _base(opened.given, path), "name": path.stem}
    for key, value, source in _differences(design):
        put(tables, key, value if source is None else {"value": value, **source})
    return to_toml(tables, {})


def _differences(design: Design) -> list[tuple[str, Any, dict[str, str] | None]]:
    """Path, value and source, if it has one, of what differs; lists as a whole."""
    found: dict[str, tuple[str, Any, dict[str, str] | None]] = {}
    for path, change in design.changes.items():
        key = whole_path(design.opened.plain, path)
        noted = {"source": change.source.source, "note": change.source.note}
        value = at_path(design.plain, key.split("."))
        found[key] = (key, value, None if change.source.source == "given" else noted)
    return list(found.values())


def _base(given: str, path: Path) -> str:
    member = parted(given)
    if given in MACHINES.names or (member is not None and member[0] in MACHINES.names):
        return given
    return Path(os.path.relpath(Path(given).resolve(), path.parent.resolve())).as_posix()
