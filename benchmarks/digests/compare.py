"""Results as files: digests in JSON, the arrays beside them, and what differs between two such files."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

Content = dict[str, Any]
"""Of a JSON file: by item what came of it."""

ROOT = Path(__file__).parents[2]


def array(values: Any) -> NDArray[np.float64]:
    """Results as float64 with one kind of NaN, since its sign and payload are no result."""
    found = np.ascontiguousarray(values, dtype=np.float64).copy()
    found[np.isnan(found)] = np.nan
    return found


def digest(values: NDArray[np.float64]) -> str:
    """SHA-256 of shape and bytes."""
    return hashlib.sha256(repr(values.shape).encode() + values.tobytes()).hexdigest()


def overall(digests: Mapping[str, str]) -> str:
    """A short digest of many, which depends on their names."""
    return hashlib.sha256(json.dumps(digests, sort_keys=True).encode()).hexdigest()[:16]


def revision(folder: Path = ROOT) -> str:
    """Commit of the working tree, with a plus where files differ from it."""
    command = ["git", "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=+"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stdout.strip()


def stored(path: Path) -> tuple[Content, Mapping[str, NDArray[np.float64]]]:
    """Digests and arrays of a file."""
    return json.loads(path.read_text(encoding="utf-8")), np.load(path.with_suffix(".npz"))


def of_revision(name: str, only: Sequence[str]) -> tuple[Content, Mapping[str, NDArray[np.float64]]]:
    """Digests and arrays that another revision's own script gives, in a worktree that is removed again."""
    with TemporaryDirectory(prefix="layflat-digests-") as folder:
        tree, out = Path(folder) / "tree", Path(folder) / "digests.json"
        subprocess.run(["git", "worktree", "add", "--quiet", "--detach", str(tree), name], cwd=ROOT, check=True)
        try:
            command = [sys.executable, "-m", "benchmarks.digests", "--out", str(out)]
            command += [part for one in only for part in ("--only", one)]
            subprocess.run(command, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree / "src")}, check=False)
            content, arrays = stored(out)
            return content, {key: arrays[key] for key in arrays}
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", str(tree)], cwd=ROOT, check=False)


def differences(
    here: Content, there: Content, ours: Mapping[str, Any], theirs: Mapping[str, Any]
) -> dict[str, tuple[bool, str]]:
    """By item of either side: whether it is the same, and what to say of it."""
    items = {**there["items"], **here["items"]}
    return {
        name: _difference(name, here["items"].get(name), there["items"].get(name), ours, theirs) for name in items
    }  # fmt: skip


def _difference(
    name: str, here: Content | None, there: Content | None, ours: Mapping[str, Any], theirs: Mapping[str, Any]
) -> tuple[bool, str]:
    if here is None or there is None:
        return (True, "new, nothing to compare with") if there is None else (False, "missing here")
    for key, both_well in (("error", False), ("skipped", True)):
        where = [place for place, item in (("here", here), ("there", there)) if key in item]
        if where:
            return both_well and len(where) == 2, f"{key} {' and '.join(where)}: {(here | there)[key]}"
    mine, other = here["arrays"], there["arrays"]
    gone = [key for key in other if key not in mine]
    changed = [key for key in other if key in mine and mine[key] != other[key]]
    if gone:
        return False, f"{len(gone)} of {len(other)} missing here, first {gone[0]!r}"
    if changed:
        largest = max((_largest(ours[f"{name}/{key}"], theirs[f"{name}/{key}"]), key) for key in changed)
        text = f"{len(changed)} of {len(other)} differ, first {changed[0]!r}"
        return False, f"{text}; most by {largest[0]:.3g} of its range, {largest[1]!r}"
    return True, "same" + (f", {len(mine) - len(other)} new" if len(mine) > len(other) else "")


def _largest(mine: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Largest difference as a share of the range of what was; infinite where shapes or missing values differ."""
    if mine.shape != other.shape:
        return np.inf
    with np.errstate(invalid="ignore"):
        apart = np.where((mine == other) | (np.isnan(mine) & np.isnan(other)), 0.0, np.abs(mine - other))
    finite = other[np.isfinite(other)]
    scale = float(np.ptp(finite)) or float(np.abs(finite).max(initial=0.0)) or 1.0 if finite.size else 1.0
    return float(np.nan_to_num(apart, nan=np.inf).max(initial=0.0)) / scale
