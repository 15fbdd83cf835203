"""JSON files of learnt corrections, each valid for one motion of one machine."""

import json
from dataclasses import asdict
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import to_json

from layflat.arrays import Array
from layflat.description.renamed import with_former_keys, with_present_keys
from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.files import write_text
from layflat.machine import Machine
from layflat.motion.learning import LearntCorrections, Repeat, RepeatedMotion
from layflat.motion.learning.corrections import CorrectionFilter
from layflat.outputs import record_output

FORMAT = "layflat learnt motion, version 1"
MOTION_ROWS = ("angles", "velocities", "accelerations")


def _former_fingerprint(machine: Machine) -> str:
    """Return the SHA-256 of the description as the last version wrote it."""
    return sha256(to_json(with_former_keys("machine", machine.model_dump(mode="json")))).hexdigest()


def write_learnt(learnt: LearntCorrections, path: Path, *, continued: bool = False) -> Path:
    """Write learnt corrections in one step, and return the path.

    Args:
        learnt: corrections, with their history.
        path: path of the file.
        continued: whether they continue those of the existing file, which is then replaced.

    Raises:
        OutputError: the file can't be written, or an existing one may not be replaced.
    """
    joints = list(learnt.machine.joints)

    def by_joint(rows: Array) -> dict[str, list[float]]:
        return dict(zip(joints, rows.T.tolist(), strict=True))

    content = {
        "format": FORMAT,
        "units": "SI: m, s, rad",
        "machine": {"name": learnt.machine.name, "sha256": learnt.machine.fingerprint},
        "motion": {"sha256": learnt.motion.fingerprint, "cycle": learnt.motion.cycle}
        | {name: by_joint(getattr(learnt.motion, name)) for name in MOTION_ROWS},
        "repeats": len(learnt.history),
        "history": [asdict(repeat) for repeat in learnt.history],
        "filter": learnt.filter._asdict(),
        "gain": learnt.gain,
        "correction": {"next": by_joint(learnt.sent), "best": by_joint(learnt.best), "step": by_joint(learnt.step)},
    }
    write_text(path, _format_json(content) + "\n", owned=continued)
    if continued:
        record_output(path)
    return path


def read_learnt(path: Path, machine: Machine, motion: RepeatedMotion | None = None) -> LearntCorrections:
    """Read the learnt corrections of a machine's motion.

    Args:
        path: path of the file.
        machine: required machine.
        motion: required motion; default: the one in the file.

    Raises:
        InputError: the file is of another machine or motion, was changed, or holds no learnt corrections.
    """
    check_regular(path, str(path), "give a file that `layflat motion learn` has written")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"its format is not {FORMAT!r}")
        content, _ = with_present_keys("learnt motion", content)
        _check_machine(content["machine"], machine, path)
        learnt = _parse_learnt(content, machine)
        _check_motion(content["motion"]["sha256"], learnt, motion, path)
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        what = f"can't be read as learnt corrections ({' '.join(str(error).split()) or type(error).__name__})"
        raise InputError(what, where=str(path), right="give a file that `layflat motion learn` has written") from None
    return learnt


def _check_machine(recorded: dict[str, str], machine: Machine, path: Path) -> None:
    """Raise InputError if corrections were learnt with another machine or description."""
    if recorded["sha256"] not in {machine.fingerprint, _former_fingerprint(machine)}:
        name = recorded["name"]
        other = f"another machine, {name!r}" if name != machine.name else f"another description of {machine.name}"
        raise InputError(f"was learnt with {other}", where=str(path), right="give that machine, or learn anew")


def _check_motion(fingerprint: str, learnt: LearntCorrections, motion: RepeatedMotion | None, path: Path) -> None:
    """Raise InputError if the file's motion was changed, or is not the given one."""
    if learnt.motion.fingerprint != fingerprint:
        raise InputError("holds a motion that was changed", where=str(path), right="learn anew")
    if motion is not None and motion.fingerprint != fingerprint:
        raise InputError("was learnt for another motion", where=str(path), right="give that motion, or learn anew")


def _parse_learnt(content: dict[str, Any], machine: Machine) -> LearntCorrections:
    """Return the corrections in a file's content; raise KeyError, TypeError or ValueError for invalid content."""

    def rows(by_joint: dict[str, list[float]]) -> Array:
        """Return values by joint as rows, (values, joints); raise ValueError if they are not finite numbers."""
        values = np.array([by_joint[name] for name in machine.joints], dtype=np.float64).T
        if values.ndim != 2 or not np.isfinite(values).all():
            raise ValueError("not all values are numbers")
        return np.ascontiguousarray(values)

    recorded, correction = content["motion"], content["correction"]
    times = CorrectionFilter(**{name: float(value) for name, value in content["filter"].items()})
    if not all(0.0 < value < inf for value in (*times, float(recorded["cycle"]), float(content["gain"]))):
        raise ValueError("a time or the gain is not positive")
    motion = RepeatedMotion(float(recorded["cycle"]), *(rows(recorded[name]) for name in MOTION_ROWS))
    learnt = LearntCorrections(
        machine,
        motion,
        times,
        float(content["gain"]),
        sent=rows(correction["next"]),
        best=rows(correction["best"]),
        step=rows(correction["step"]),
        history=tuple(Repeat(**repeat) for repeat in content["history"]),
    )
    if {len(part) for part in (learnt.sent, learnt.best, learnt.step)} != {learnt.corrections.count}:
        raise ValueError("the correction does not fit the motion")
    return learnt


def _format_json(content: dict[str, Any], indent: str = "") -> str:
    """Return nested tables as JSON, with a line for each list of numbers and for each table in a list."""
    inner = indent + "  "
    lines = []
    for key, value in content.items():
        if isinstance(value, dict):
            text = _format_json(value, inner)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n" + ",\n".join(f"{inner}  {json.dumps(item)}" for item in value) + f"\n{inner}]"
        else:
            text = json.dumps(value)
        lines.append(f"{inner}{json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
