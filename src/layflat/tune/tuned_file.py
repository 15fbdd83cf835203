"""Gains that were found, as a description that extends the one they were found for."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine import Machine, load, names
from layflat.machine.change import value_at
from layflat.machine.listing import to_toml
from layflat.machine.provenance import Provenance
from layflat.tune.knobs import INTEGRAL_LIMIT, Knob


def tuned_path(given: str, folder: Path) -> Path:
    """Where the tuned description of a built-in machine or a file is put.

    Raises:
        InputError: the file can't be extended from there.
    """
    path = folder / f"{Path(given).stem}-tuned.toml"
    if given in names():
        return path
    if Path(given).suffix != ".toml":
        raise InputError("can't be extended", where=given, right="give it a name that ends in .toml")
    if path.resolve() in _ancestry(Path(given)):
        raise InputError("would be overwritten, and extends it", where=str(path), right="give another folder")
    return path


def write_tuned(
    given: str, base: Machine, knobs: Sequence[Knob], values: Sequence[float], note: str, path: Path
) -> Machine:
    """Write the gains and load what was written.

    Args:
        given: built-in name or file of the base.
        base: the machine that it describes, which may lack gains.
        knobs: what was turned.
        values: in the knobs' units.
        note: how they were found.
        path: from `tuned_path`.

    Raises:
        OutputError: it can't be written there.
    """
    texts = {knob.paths[0]: str(knob.text(value)) for knob, value in zip(knobs, values, strict=True)}
    sources = dict.fromkeys(texts, Provenance("calibrated", note))
    for name in base.joints:
        if base.joint[name].gains is None:
            limit = f"joint.{name}.gains.integral_limit"
            texts[limit] = f"{INTEGRAL_LIMIT * value_at(base, 'valve.volts_to_full'):g} V"
            sources[limit] = Provenance("assumed", f"{100 * INTEGRAL_LIMIT:g} % of full opening")
    plain: dict[str, Any] = {
        "extends": given if given in names() else os.path.relpath(Path(given).resolve(), path.parent.resolve()),
        "name": path.stem,
        "title": f"{base.title}, tuned",
    }
    for key, text in texts.items():
        *tables, last = key.split(".")
        table = plain
        for part in tables:
            table = table.setdefault(part, {})
        table[last] = text
    with whole_file(path) as temporary:
        temporary.write_text(to_toml(plain, sources), encoding="utf-8")
    return load(path)


def _ancestry(path: Path) -> list[Path]:
    """A file that loads, and the files that it extends."""
    found = [path.resolve()]
    base = tomllib.loads(path.read_text(encoding="utf-8")).get("extends", "")
    below = path.parent / base
    return found + (_ancestry(below) if below.suffix == ".toml" else [])
