"""Saving of results, and of a description that holds only its differences from the opened one."""

import os
import re
import tempfile
from copy import deepcopy
from pathlib import Path
from typing import Any

from layflat.description.names import file_name
from layflat.description.tables import Plain
from layflat.design.summary import Finding
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine.cloud import split_member_name
from layflat.machine.listing import nested_value, to_toml
from layflat.machine.loader import MACHINE_LIBRARY, load
from layflat.machine.stale import stale_values, tubes_counted_twice
from layflat.pages.studio.design import Design, set_at_path, sources_of, whole_path

NAME_FIELD = "name"
NAME_ADVICE = 'give a name such as "my-arm", or "designs/my-arm" for a subfolder'


def file_below(root: Path, name: str, suffix: str) -> Path:
    """Return the path of a file or folder below a folder.

    Args:
        root: folder that nothing is written outside of.
        name: name of the file, with or without its suffix, and of subfolders before it.
        suffix: such as ".toml"; "" for a folder.

    Raises:
        InputError: the name can't be that of a file, or leads out of the folder.
    """
    text = name.strip()
    if text.startswith(("/", "~")) or "\\" in text or re.match(r"[A-Za-z]:", text):
        raise InputError(
            f"{text!r} is not below the folder that the studio was started in", where=NAME_FIELD, right=NAME_ADVICE
        )
    parts = text.split("/")
    if not parts[-1].endswith(suffix):
        parts[-1] += suffix
    for part in parts:
        file_name(part.removesuffix(suffix) if part is parts[-1] and suffix else part, NAME_FIELD)
    path = root.resolve().joinpath(*parts)
    if not path.parent.resolve().is_relative_to(root.resolve()) or path.is_symlink():
        raise InputError(f"{text!r} leads out of the folder by a link", where=NAME_FIELD, right="give another name")
    if suffix and path.is_dir():
        raise InputError(f"{text!r} is a folder", where=NAME_FIELD, right="give another name")
    return path


def refuse_base(design: Design, path: Path) -> None:
    """Raise InputError if a path is a file that the design extends: saved there it would extend itself."""
    opened = design.opened
    if path.resolve() in opened.files and path.resolve() != opened.file:
        raise InputError(f"this design extends {path.name!r}", where=NAME_FIELD, right="give another name")


def save(design: Design, path: Path) -> Path:
    """Write a design as a description, replacing an existing file, and return its path.

    The description extends the opened one and holds only the differences. Over its own file it holds that file's values
    with the changes. If the opened description has changed on disk or was saved over, another file is complete instead.

    Raises:
        InputError: it would overwrite a file that it extends, or the file read again is not the design.
        OutputError: the file can't be written.
    """
    refuse_base(design, path)
    is_own_file = path.resolve() == design.opened.file
    with whole_file(path) as temporary:
        temporary.write_text(_description_text(design, path), encoding="utf-8")
        if load(str(temporary)).model_copy(update={"name": design.machine.name}) != design.machine:
            right = "reload what was opened, or give another name"
            problem = "can't be saved: a file that it extends has changed since it was opened"
            raise InputError(problem, where=str(path), right=right)
    if is_own_file:
        design.opened = design.opened.as_rewritten()
    return path


def list_stale(design: Design) -> list[Finding]:
    """Return the findings of `layflat machine check` about values of other sizes, and tubes that are counted twice.

    They are those of the description that `save` would write; none for a design without changes.
    """
    if not design.changes:
        return []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "design.toml"
        path.write_text(_description_text(design, path), encoding="utf-8")
        machine = load(str(path))
        findings = [("stale", one) for one in stale_values(machine)] + [
            ("volume", one) for one in tubes_counted_twice(machine)
        ]
    return [
        Finding("warning" if rule == "stale" else "note", rule, one.path, one.what, one.right) for rule, one in findings
    ]


def _description_text(design: Design, path: Path) -> str:
    """Return the TOML text of a design at a path.

    The opened file itself is written whole with its changes. Other files extend the opened description and hold the
    differences only, or all values if the opened files were rewritten or have changed on disk.
    """
    opened, changes = design.opened, design.changes
    sources = sources_of(opened, changes)
    if path.resolve() == opened.file:
        own_tables = deepcopy(opened.own_tables)
        for key, value, source in _differences(design):
            set_at_path(own_tables, key, value if source is None else {"value": value, **source})
        return to_toml(own_tables, {})
    if opened.rewritten or opened.changed_on_disk():
        return to_toml({**design.plain, "name": path.stem}, sources)
    tables: Plain = {"extends": _extended_name(opened.name, path), "name": path.stem}
    for key, value, source in _differences(design):
        set_at_path(tables, key, value if source is None else {"value": value, **source})
    return to_toml(tables, {})


def _differences(design: Design) -> list[tuple[str, Any, dict[str, str] | None]]:
    """Return path, value and source table of all changes; lists as a whole. The source is None where it is "given"."""
    differences: dict[str, tuple[str, Any, dict[str, str] | None]] = {}
    for path, change in design.changes.items():
        key = whole_path(design.opened.plain, path)
        noted = {"source": change.source.source, "note": change.source.note}
        value = nested_value(design.plain, key.split("."))
        differences[key] = (key, value, None if change.source.source == "given" else noted)
    return list(differences.values())


def _extended_name(opened: str, path: Path) -> str:
    """Return the name by which a file at `path` extends the opened description: a built-in name, or a relative path."""
    member = split_member_name(opened)
    if opened in MACHINE_LIBRARY.names or (member is not None and member[0] in MACHINE_LIBRARY.names):
        return opened
    return Path(os.path.relpath(Path(opened).resolve(), path.parent.resolve())).as_posix()
