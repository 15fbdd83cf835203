"""From the files of logs to what a bench takes: read, checked, and over the clock that suits it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, BenchDescription
from layflat.identify.benches.kinds import bench_of, chosen_blocks
from layflat.identify.logs import Issue, Table, check, read_log, read_table, refuse
from layflat.identify.logs.checks.excited import NOTHING_MOVES
from layflat.identify.logs.issue import ordered, several
from layflat.machine import Machine

if TYPE_CHECKING:
    import xarray

NAMED = 3
"""Values, and motions, that are named where there are more."""


@dataclass(frozen=True)
class Recorded:
    """Logs of a bench.

    Args:
        bench: that they were recorded on.
        blocks: what is fitted.
        fitted: logs to fit, by name.
        validation: logs that are only predicted.
        issues: what is doubtful in each log.
    """

    bench: Bench
    blocks: Sequence[str]
    fitted: Mapping[str, xarray.Dataset]
    validation: Mapping[str, xarray.Dataset]
    issues: Mapping[str, Sequence[Issue]]


def recorded(
    described: Machine | BenchDescription,
    logs: Sequence[Path],
    validate: Sequence[Path],
    blocks: str | None,
    mapping: str | Path | None,
) -> Recorded:
    """Read and check logs.

    Raises:
        InputError: in one line, what is wrong with a log or an option.
    """
    files = named([*logs, *validate])
    machine = described if isinstance(described, Machine) else None
    joints = list(machine.joints) if machine is not None else None
    tables = {name: read_table(file) for name, file in files.items()}
    whole = {name: read_log(table, mapping, joints=joints) for name, table in tables.items()}
    bench = bench_of(described, {name: whole[name] for name in list(files)[: len(logs)]})
    fitted = chosen_blocks(bench, blocks)
    given, issues = {}, {}
    for name, table in tables.items():
        found = check(whole[name], machine)
        if [issue for issue in found if issue.severity == "error"] == [NOTHING_MOVES]:
            _refuse_rest(described, bench, fitted, whole[name], str(table.path))
        refuse(found, str(table.path))
        given[name], late = _for(bench, machine, table, mapping)
        issues[name] = ordered([*found, *late])
    count = len(logs)
    names = list(files)
    return Recorded(bench, fitted, {n: given[n] for n in names[:count]}, {n: given[n] for n in names[count:]}, issues)


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


def _for(
    bench: Bench, machine: Machine | None, table: Table, mapping: str | Path | None
) -> tuple[xarray.Dataset, list[Issue]]:
    """A log over the clock of its bench, and what there is to say of that."""
    if not bench.even:
        return read_log(table, mapping, joints=list(machine.joints) if machine else None, as_recorded=True), []
    if machine is None:
        return _begun(read_log(table, mapping))
    return _begun(read_log(table, mapping, joints=list(machine.joints), cycle=machine.cycle))


def _begun(log: xarray.Dataset) -> tuple[xarray.Dataset, list[Issue]]:
    """A log from the first instant on at which every signal is known: a simulation begins with all of them."""
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


def _refuse_rest(
    described: Machine | BenchDescription,
    bench: Bench,
    blocks: Sequence[str],
    log: xarray.Dataset,
    file: str,
) -> None:
    """Refuse a log in which nothing moves: say what it can't identify, and what to record.

    Raises:
        InputError: always.
    """
    unknowns = [one for one in bench.model(described, {"log": log}, blocks, {}).unknowns if not one.nuisance]
    excitations = list(dict.fromkeys(one.excitation for one in unknowns if one.excitation))
    what = f"{NOTHING_MOVES.text}: it can't identify {_first([one.path for one in unknowns])}"
    sequence = " (`layflat excite` writes such a sequence)" if isinstance(described, Machine) else ""
    raise InputError(what, where=file, right=f"record {_first(excitations, '; ')}{sequence}")


def _first(names: Sequence[str], between: str = ", ") -> str:
    more = len(names) - NAMED
    return between.join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
