"""What a fit asks of logs: a name of their own, a beginning with all signals, and that something moves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layflat.errors import InputError
from layflat.identify.logs import Issue
from layflat.identify.logs.checks.excited import NOTHING_MOVES
from layflat.identify.logs.issue import several
from layflat.identify.model import Model

if TYPE_CHECKING:
    import xarray

NAMED = 3
"""Values, and motions, that are named where there are more."""


def named(files: Sequence[Path]) -> dict[str, Path]:
    """Files by the names of their logs.

    Raises:
        InputError: two have the same.
    """
    found: dict[str, Path] = {}
    for file in files:
        if file.stem in found:
            what = "is given twice" if file == found[file.stem] else f"has the same name as {found[file.stem]}"
            raise InputError(what, where=str(file), right="give every log once, under a name of its own")
        found[file.stem] = file
    return found


def begun(log: xarray.Dataset) -> tuple[xarray.Dataset, list[Issue]]:
    """Cut a log to begin where every signal is known, as a simulation begins with all of them; and say what is cut."""
    columns = {
        f"{name}.{values['joint'].values[j]}" if values.ndim > 1 else str(name): column
        for name, values in log.data_vars.items()
        for j, column in enumerate(np.atleast_2d(values.transpose("time", ...).to_numpy().T))
        if np.isfinite(column).any()
    }
    known = np.isfinite(np.stack(list(columns.values())))
    if known[:, 0].all() or not known.all(axis=0).any():
        return log, []
    first = int(np.argmax(known.all(axis=0)))
    late = [name for name, row in zip(columns, known, strict=True) if not row[:first].all()]
    left = float(log["time"][first])
    rest = log.isel(time=slice(first, None))
    rest = rest.assign_coords(time=("time", rest["time"].to_numpy() - left, log["time"].attrs))
    rest.attrs["log_start"] = float(log.attrs["log_start"]) + left
    text = f"is not known from the log's start on; its first {left:.3g} s are left out"
    return rest, [Issue("warning", several(late), text, "a simulation begins with all signals")]


def refuse_rest(model: Model, sequence: str, file: str) -> None:
    """Refuse a log in which nothing moves: say what it can't identify, and what to record.

    Args:
        model: of this log.
        sequence: what to say of a sequence to record.
        file: of the log.

    Raises:
        InputError: always.
    """
    unknowns = [one for one in model.unknowns if not one.nuisance]
    excitations = list(dict.fromkeys(one.excitation for one in unknowns if one.excitation))
    what = f"{NOTHING_MOVES.text}: it can't identify {_first([one.path for one in unknowns])}"
    raise InputError(what, where=file, right=f"record {_first(excitations, '; ')}{sequence}")


def _first(names: Sequence[str], between: str = ", ") -> str:
    more = len(names) - NAMED
    return between.join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
