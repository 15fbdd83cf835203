"""Migration of files of the last version: keys get their present names, and every other character stays."""

import json
import os
from codecs import BOM_UTF8
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from layflat.cell.file.loader import CELL_LIBRARY, LAYOUT_LIBRARY
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import ContainerLayout
from layflat.description.explain import unknown_key
from layflat.description.key_tokens import names_in, replace_names
from layflat.description.renamed import RenamedKey, present_path, with_present_keys
from layflat.description.tables import Plain, overlay, parse_toml, split_provenance
from layflat.description.text import exists, read_text
from layflat.design.arm import TASK_LIBRARY, ArmTask
from layflat.errors import InputError, OutputError
from layflat.files import whole_file
from layflat.identify.benches.loader import KINDS, description_class
from layflat.identify.logs.mapping import LogMapping
from layflat.machine import Machine
from layflat.machine.cloud import REQUIRED_KEYS, split_member_name
from layflat.machine.loader import BENCH_LIBRARY, MACHINE_LIBRARY
from layflat.motion.file import MOTION_LIBRARY, MotionDescription
from layflat.motion.learning.file import FORMAT
from layflat.study.description import StudyFile
from layflat.study.study import STUDY_LIBRARY

DESCRIPTION_CLASSES: dict[str, type[BaseModel]] = {
    MACHINE_LIBRARY.noun: Machine,
    CELL_LIBRARY.noun: Cell,
    LAYOUT_LIBRARY.noun: ContainerLayout,
    MOTION_LIBRARY.noun: MotionDescription,
    TASK_LIBRARY.noun: ArmTask,
    STUDY_LIBRARY.noun: StudyFile,
    "mapping": LogMapping,
}
"""Classes of TOML files by their nouns; that of a test bench follows from its `kind`."""

DESCRIPTION_LIBRARIES = (
    MACHINE_LIBRARY,
    BENCH_LIBRARY,
    CELL_LIBRARY,
    LAYOUT_LIBRARY,
    MOTION_LIBRARY,
    TASK_LIBRARY,
    STUDY_LIBRARY,
)

MAX_CHAIN = 20  # files that extend each other

COMMON_KEYS = {"name", "title", "extends", "omits"}  # of files of several kinds

MAX_FILE_BYTES = 100_000_000  # of a learnt motion or a cloud

EXAMPLE_LINE = 'width = "160 mm"'

FILES_ADVICE = "give a machine, test bench, cell, study, motion, arm task, mapping, learnt motion or cloud"


@dataclass(frozen=True)
class Migration:
    """A file, and its text with present keys."""

    path: Path
    renamed: list[RenamedKey]
    text: str

    def write(self) -> None:
        """Replace the file in one step, if a key is renamed; its permissions stay.

        Raises:
            OutputError: the file can't be written.
        """
        if not self.renamed:
            return
        place = self.path.resolve()  # a link stays one
        if not os.access(place, os.W_OK):
            raise OutputError("is write-protected", where=str(self.path), right="allow writing, or migrate a copy")
        mode = place.stat().st_mode
        mark = BOM_UTF8 if place.read_bytes().startswith(BOM_UTF8) else b""
        with whole_file(place, owned=True) as temporary:
            temporary.write_bytes(mark + self.text.encode())
        place.chmod(mode)


def plan_migration(path: Path) -> Migration:
    """Return the migration of a file, which stays as it is until `Migration.write`.

    Raises:
        InputError: it can't be read, is no file that layflat knows, or has a key that no version has.
    """
    where = str(path)
    text = read_text(path, where, FILES_ADVICE, max_bytes=MAX_FILE_BYTES)
    plain = _parse(text, where)
    if _is_json(text):
        present, renamed = with_present_keys(_noun_of_json(plain, where), plain, where, certain=False)
    else:
        noun, base = _base_tables(plain, path)
        noun, model = _description_class(plain, base, noun, where)
        present, renamed = with_present_keys(noun, plain, where, certain=False)
        _refuse_unknown_keys(model, present, base, path)
    return Migration(path, renamed, _rewrite(text, renamed, present, where) if renamed else text)


def _is_json(text: str) -> bool:
    return text.lstrip().startswith("{")


def _parse(text: str, where: str) -> Plain:
    """Return the content of a TOML or JSON file; raise InputError, naming `where`, if it is neither."""
    if not _is_json(text):
        return parse_toml(text, where, EXAMPLE_LINE)
    try:
        content: Plain = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError("is neither TOML nor JSON", where=where, right=FILES_ADVICE) from None
    return content


def _noun_of_json(content: Plain, where: str) -> str:
    """Return the noun of a JSON file: "learnt motion" or "cloud"; raise InputError for any other."""
    if content.get("format") == FORMAT:
        return "learnt motion"
    if all(key in content for key in REQUIRED_KEYS):
        return "cloud"
    raise InputError("is no file that layflat knows", where=where, right=FILES_ADVICE)


def _base_tables(plain: Plain, path: Path, depth: int = 0) -> tuple[str, Plain]:
    """Return noun and tables of the description that a file extends; the noun is empty if none of them is built in.

    Both are empty for a file that extends none, or one that does not exist.

    Args:
        plain: tables of the file.
        path: of the file.
        depth: number of files that extend it.
    """
    base = plain.get("extends")
    if not isinstance(base, str) or depth > MAX_CHAIN:
        return "", {}
    if split_member_name(base):
        return MACHINE_LIBRARY.noun, MACHINE_LIBRARY.tables(base)[0]
    library = next((one for one in DESCRIPTION_LIBRARIES if base in one.names), None)
    if library is not None:
        return library.noun, library.tables(base)[0]
    file = path.parent / base
    if not exists(file):
        return "", {}
    own = parse_toml(read_text(file, str(file), FILES_ADVICE), str(file), EXAMPLE_LINE)
    noun, below = _base_tables(own, file, depth + 1)
    return noun, overlay(below, split_provenance(own, str(file))[0])


def _description_class(plain: Plain, base: Plain, noun: str, where: str) -> tuple[str, type[BaseModel]]:
    """Return noun and class of a TOML file.

    Args:
        plain: its tables.
        base: those that it extends.
        noun: of the built-in description that it extends; empty: the one that has most of the keys.
        where: the file, for messages.

    Raises:
        InputError: no class has any of the keys.
    """
    kind = str(plain.get("kind", base.get("kind")))
    if kind in KINDS and noun in {"", BENCH_LIBRARY.noun}:
        return BENCH_LIBRARY.noun, description_class(kind)

    def fitting(noun: str) -> int:
        names = {present_path(noun, key) for key in (plain.keys() | base.keys()) - COMMON_KEYS}
        return len(names & DESCRIPTION_CLASSES[noun].model_fields.keys())

    best = noun or max(DESCRIPTION_CLASSES, key=fitting)
    if not noun and fitting(best) == 0:
        raise InputError("is no file that layflat knows", where=where, right=FILES_ADVICE)
    return best, DESCRIPTION_CLASSES[best]


def _refuse_unknown_keys(model: type[BaseModel], present: Plain, base: Plain, path: Path) -> None:
    """Raise InputError if a file has a key that its class has not; whatever else is wrong does not matter here.

    Args:
        model: class of the description.
        present: tables of the file, with present keys.
        base: those that it extends.
        path: of the file.
    """
    plain, _ = split_provenance(present, str(path))
    parts = [(model, {key: value for key, value in plain.items() if key not in {"extends", "omits"}}, base, str(path))]
    for i, variant in enumerate(plain.get("variant", []) if model is StudyFile else []):
        _, machine = _base_tables({"extends": variant.get("machine", plain.get("machine"))}, path)
        parts.append((Machine, variant.get("set", {}), machine, f"{path}: variant.{i}.set"))
    for described, part, below, where in parts:
        try:
            described.model_validate(_with_kinds(part, below))
        except ValidationError as error:
            if (unknown := unknown_key(error, where, described)) is not None:
                raise unknown from None


def _with_kinds(part: Any, below: Any) -> Any:
    """Return tables with the kinds of those that they overlay, where they name none."""
    if not (isinstance(part, dict) and isinstance(below, dict)):
        return part
    kind = {"kind": below["kind"]} if "kind" in below else {}
    return kind | {key: _with_kinds(value, below.get(key)) for key, value in part.items()}


def _rewrite(text: str, renamed: list[RenamedKey], present: Plain, where: str) -> str:
    """Return a text with renamed keys and paths.

    Args:
        text: of the file.
        renamed: keys and paths.
        present: the parsed content with present keys, which the new text has to have.
        where: the file, for messages.

    Raises:
        InputError: the new text has another content, since a key is written in an unusual way.
    """
    names = {one.steps: one.present for one in renamed}
    tokens = [token for token in names_in(text, json=_is_json(text)) if token.is_name and token.steps in names]
    new = replace_names(text, {token: names[token.steps] for token in tokens})
    if _parse(new, where) != present:
        raise InputError("writes a renamed key in an unusual way", where=where, right="rename it by hand")
    return new
