"""What was learnt as a file, in JSON: for one motion of one machine, and refused for any other."""

import json
from dataclasses import asdict
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.files import write_text
from layflat.machine import Machine
from layflat.motion.learning.corrections import Filtering
from layflat.motion.learning.learnt import Learnt, Repeat, Wanted
from layflat.outputs import record_output

FORMAT = "layflat learnt motion, version 1"
ROWS = ("angles", "velocities", "accelerations")


def machine_fingerprint(machine: Machine) -> str:
    """Return the SHA-256 of a machine's complete description."""
    return sha256(machine.model_dump_json().encode()).hexdigest()


def write_learnt(learnt: Learnt, path: Path, *, continued: bool = False) -> Path:
    """Write what was learnt, whole or not at all, and return its path.

    Args:
        learnt: what was learnt.
        path: where it is to be.
        continued: whether it goes on from the file that is there, and keeps what that holds.

    Raises:
        OutputError: it can't be written there.
    """
    joints = list(learnt.machine.joints)

    def by_joint(rows: Array) -> dict[str, list[float]]:
        return dict(zip(joints, rows.T.tolist(), strict=True))

    content = {
        "format": FORMAT,
        "units": "SI: m, s, rad",
        "machine": {"name": learnt.machine.name, "sha256": machine_fingerprint(learnt.machine)},
        "motion": {"sha256": learnt.wanted.fingerprint, "cycle": learnt.wanted.cycle}
        | {name: by_joint(getattr(learnt.wanted, name)) for name in ROWS},
        "repeats": len(learnt.history),
        "history": [asdict(repeat) for repeat in learnt.history],
        "filter": learnt.how._asdict(),
        "gain": learnt.gain,
        "correction": {"next": by_joint(learnt.sent), "best": by_joint(learnt.best), "step": by_joint(learnt.step)},
    }
    write_text(path, _laid_out(content) + "\n", owned=continued)
    if continued:
        record_output(path)
    return path


def read_learnt(path: Path, machine: Machine, wanted: Wanted | None = None) -> Learnt:
    """Read what was learnt of a machine's motion.

    Args:
        path: of the file.
        machine: that it has to be of.
        wanted: the motion that it has to be of; default: whichever is in the file.

    Raises:
        InputError: it is of another machine or motion, was changed, or is no such file.
    """
    check_regular(path, str(path), "give a file that `layflat learn` has written")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"its format is not {FORMAT!r}")
        _check_machine(content["machine"], machine, path)
        learnt = _learnt(content, machine)
        _check_motion(content["motion"]["sha256"], learnt, wanted, path)
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        what = f"can't be read as what was learnt ({' '.join(str(error).split()) or type(error).__name__})"
        raise InputError(what, where=str(path), right="give a file that `layflat learn` has written") from None
    return learnt


def _check_machine(of: dict[str, str], machine: Machine, path: Path) -> None:
    if of["sha256"] != machine_fingerprint(machine):
        what = "another machine" if of["name"] != machine.name else f"another description of {machine.name}"
        told = f"was learnt with {what}, {of['name']!r}" if of["name"] != machine.name else f"was learnt with {what}"
        raise InputError(told, where=str(path), right="give that machine, or learn anew")


def _check_motion(fingerprint: str, learnt: Learnt, wanted: Wanted | None, path: Path) -> None:
    if learnt.wanted.fingerprint != fingerprint:
        raise InputError("holds a motion that was changed", where=str(path), right="learn anew")
    if wanted is not None and wanted.fingerprint != fingerprint:
        raise InputError("was learnt of another motion", where=str(path), right="give that motion, or learn anew")


def _learnt(content: dict[str, Any], machine: Machine) -> Learnt:
    """Return what a file's content says; raise KeyError, TypeError or ValueError for what makes no sense."""

    def rows(of: dict[str, list[float]]) -> Array:
        found = np.array([of[name] for name in machine.joints], dtype=np.float64).T
        if found.ndim != 2 or not np.isfinite(found).all():
            raise ValueError("not all values are numbers")
        return np.ascontiguousarray(found)

    motion, correction = content["motion"], content["correction"]
    how = Filtering(**{name: float(value) for name, value in content["filter"].items()})
    if not all(0.0 < value < inf for value in (*how, float(motion["cycle"]), float(content["gain"]))):
        raise ValueError("a time or the gain is not positive")
    wanted = Wanted(float(motion["cycle"]), *(rows(motion[name]) for name in ROWS))
    learnt = Learnt(
        machine,
        wanted,
        how,
        float(content["gain"]),
        sent=rows(correction["next"]),
        best=rows(correction["best"]),
        step=rows(correction["step"]),
        history=tuple(Repeat(**repeat) for repeat in content["history"]),
    )
    if {len(part) for part in (learnt.sent, learnt.best, learnt.step)} != {learnt.corrections.count}:
        raise ValueError("the correction does not fit the motion")
    return learnt


def _laid_out(content: dict[str, Any], indent: str = "") -> str:
    """Return JSON with a line for each list of numbers."""
    inner = indent + "  "
    lines = []
    for key, value in content.items():
        if isinstance(value, dict):
            text = _laid_out(value, inner)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n" + ",\n".join(f"{inner}  {json.dumps(item)}" for item in value) + f"\n{inner}]"
        else:
            text = json.dumps(value)
        lines.append(f"{inner}{json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
