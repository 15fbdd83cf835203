"""Sequences of places that an operator saves: TOML files in one folder, a file a sequence."""

import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import degrees, radians
from pathlib import Path
from typing import Any

import tomli_w

from layflat.description.names import file_name
from layflat.errors import InputError
from layflat.files import write_text
from layflat.machine import Machine
from layflat.machine.parameters import check_inside_stroke
from layflat.pages.panel.moves import Step

MAX_LISTED = 200  # sequences that a page offers
SUFFIX = ".sequence.toml"
LONGEST_PAUSE, MAX_STEPS = 3600.0, 500  # of a step, s, and steps of a sequence


def sequence_names(folder: Path) -> list[str]:
    """Return the names of the sequences in a folder."""
    return sorted(path.name.removesuffix(SUFFIX) for path in folder.glob(f"*{SUFFIX}"))


def newest_names(folder: Path) -> tuple[list[str], int]:
    """Return the names of the newest sequences in a folder, in order, and how many older ones there are."""
    found = []
    for path in folder.glob(f"*{SUFFIX}"):
        with suppress(OSError):  # it went meanwhile
            found.append((path.stat().st_mtime, path.name.removesuffix(SUFFIX)))
    newest = sorted(found, reverse=True)[:MAX_LISTED]
    return sorted(name for _, name in newest), len(found) - len(newest)


def place_of(folder: Path, name: str) -> Path:
    """Return the file of a sequence; raise InputError if it is no name for one."""
    return folder / f"{file_name(name, 'name')}{SUFFIX}"


def is_saved(folder: Path, name: str) -> bool:
    """Return whether a sequence of this name is there; raise InputError if it is no name for one."""
    return place_of(folder, name).exists()


def save_sequence(folder: Path, name: str, machine: Machine, steps: Sequence[Step]) -> Path:
    """Write a sequence of a machine's joints, and return its file.

    Args:
        folder: in which sequences are kept.
        name: of the sequence.
        machine: whose joints move.
        steps: 1 to `MAX_STEPS`.

    Raises:
        InputError: the name can't be one of a file, or there are too many steps.
        OutputError: it can't be written.
    """
    if len(steps) > MAX_STEPS:
        raise InputError(f"has {len(steps)} steps", where=name, right=f"give {MAX_STEPS} at most")
    rows = [_row(step, machine) for step in steps]
    return write_text(place_of(folder, name), tomli_w.dumps({"machine": machine.name, "step": rows}))


def _row(step: Step, machine: Machine) -> dict[str, Any]:
    angles = {joint: f"{degrees(at):.3f} deg" for joint, at in zip(machine.joints, step.angles, strict=True)}
    outputs = {} if step.outputs is None else {"outputs": sorted(step.outputs)}
    return {"angles": angles, "pause": f"{step.pause:.3f} s", **outputs}


def load_sequence(folder: Path, name: str, machine: Machine) -> list[Step]:
    """Read a sequence of a machine.

    Raises:
        InputError: there is none of that name, it is not one, or of other joints, or leaves the working stroke.
    """
    path = place_of(folder, name)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"can't be read ({error})", where=str(path)) from None
    rows = table.get("step")
    if not isinstance(rows, list) or not 0 < len(rows) <= MAX_STEPS:
        raise InputError("holds no steps", where=str(path), right=f"give 1 to {MAX_STEPS} tables [[step]]")
    return [_step(row, machine, f"{path}: step {count}") for count, row in enumerate(rows, 1)]


def _step(row: Any, machine: Machine, where: str) -> Step:
    from layflat.description import units as u  # noqa: PLC0415

    angles = row.get("angles") if isinstance(row, Mapping) else None
    if not isinstance(angles, Mapping) or set(angles) != set(machine.joints):
        right = f"give angles of {', '.join(machine.joints)}"
        raise InputError("names other joints than the machine has", where=where, right=right)
    found = [u.quantity(angles[name], u.ANGLE, f"{where}: {name}") for name in machine.joints]
    for name, angle in zip(machine.joints, found, strict=True):
        check_inside_stroke(machine, name, angle, where)
    pause = u.quantity(row.get("pause", "0 s"), u.TIME, f"{where}: pause")
    return Step(tuple(found), check_pause(pause, where), _outputs(row.get("outputs"), machine, where))


def _outputs(names: Any, machine: Machine, where: str) -> frozenset[str] | None:
    known = machine.interface.outputs
    if names is None:
        return None
    if not isinstance(names, list) or not set(map(str, names)) <= set(known):
        right = f"give a list of {', '.join(known)}" if known else "leave them out: the machine has none"
        raise InputError(f"{names!r} are not outputs of the machine", where=f"{where}: outputs", right=right)
    return frozenset(names)


def check_pause(seconds: float, where: str) -> float:
    """Return a pause, s; raise InputError if it is none."""
    if not 0.0 <= seconds <= LONGEST_PAUSE:
        raise InputError(f"a pause of {seconds:g} s", where=where, right=f"give 0 to {LONGEST_PAUSE:g} s")
    return seconds


def target(machine: Machine, values: Mapping[str, float | None]) -> tuple[float, ...]:
    """Return the angles (rad) of a target given in degrees by joint; raise InputError if one is outside its stroke."""
    found = []
    for name in machine.joints:
        value = values.get(name)
        if value is None:
            raise InputError("lacks an angle", where=name, right="give a number of degrees")
        check_inside_stroke(machine, name, radians(value), name)
        found.append(radians(value))
    return tuple(found)
