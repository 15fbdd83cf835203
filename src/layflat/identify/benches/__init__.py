"""Contract of every kind of test bench: a description that a file holds, and a model of its logs."""

from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description import Part
from layflat.description.change import replace_value
from layflat.description.names import Name
from layflat.errors import InputError
from layflat.identify.model import FITTED_FRACTION, Model
from layflat.lanes import mapped
from layflat.parallel import run_on_all_cores

Logs = Mapping[str, Dataset]  # data sets by the logs' names
T = TypeVar("T")
Described = TypeVar("Described", bound=Part)


class BenchDescription(Part):
    """Test bench other than a machine; the `kind` at the top of its file selects its class."""

    kind: str
    name: Name
    title: str


Alternatives = Mapping[str, tuple[Any, Mapping[str, Any]]]
"""Descriptions with other laws by name, the simplest first, each with the whole parts of a file that it replaces."""


def no_alternatives(described: Any, logs: Logs, blocks: Sequence[str]) -> Alternatives:  # noqa: ARG001
    """Return no alternatives: most benches have one law.

    Args:
        described: description of the bench.
        logs: logs to be fitted.
        blocks: blocks of unknowns to be fitted.
    """
    return {}


class BenchKind(NamedTuple):
    """Functions by which the logs of a kind of bench are fitted.

    A model is built from a description (start of the search, and values that are held), the logs to fit, the logs for
    validation, which are only predicted (without any, the last third of each log is), and the `blocks` of unknowns to
    fit. It raises InputError if a log lacks a signal that it needs, or a block is unknown.
    """

    blocks: Sequence[str]
    default_blocks: Sequence[str]
    model: Callable[..., Model]
    even: bool  # logs are resampled to the simulation's time steps; otherwise every sample stays at its own stamp
    alternatives: Callable[..., Alternatives] = no_alternatives
    """Laws to be compared on the logs, from a description, logs and blocks; none: the description's own law."""


def has_samples(log: Dataset, signal: str, joint: str) -> bool:
    """Return whether a log has at least one sample, not NaN, of a joint's signal.

    Args:
        log: data set over `time`, and over `joint` where signals have one of each.
        signal: its name.
        joint: its name; not used of a signal that all joints share.
    """
    if signal not in log or ("joint" in log[signal].dims and joint not in log["joint"].values):
        return False
    values = log[signal].sel(joint=joint) if "joint" in log[signal].dims else log[signal]
    return bool(values.notnull().any())


def require_samples(logs: Logs, signals: Sequence[str], joints: Sequence[str]) -> None:
    """Check that every log has at least one sample, not NaN, of each of these signals of each joint.

    Args:
        logs: logs by name.
        signals: names of signals.
        joints: names of joints.

    Raises:
        InputError: a log lacks a signal of a joint; the first that is missing is named.
    """
    for name, signal, joint in product(logs, signals, joints):
        if not has_samples(logs[name], signal, joint):
            suffix = f" of every joint: {', '.join(joints)}" if len(joints) > 1 else ""
            right = f"map a column to the signal {signal}{suffix}"
            raise InputError(f"has no {signal} of joint {joint!r}", where=name, right=right)


def check_choices(names: Collection[str], choices: Collection[str], where: str, noun: str) -> list[str]:
    """Return each name once, in the order given, if all are among the choices.

    Args:
        names: names to be checked.
        choices: allowed names.
        where: argument or key that gives the names, for the message.
        noun: noun of one of the choices, for the message.

    Raises:
        InputError: a name is not among the choices.
    """
    unknown = [name for name in names if name not in choices]
    if unknown:
        raise InputError(f"unknown {noun} {unknown[0]!r}", where=where, right=f"choose from {', '.join(choices)}")
    return list(dict.fromkeys(names))


def select_blocks(table: Mapping[str, Sequence[T]], blocks: Collection[str]) -> list[T]:
    """Return the items of a table for the chosen blocks, in the table's order; InputError for an unknown block."""
    check_choices(blocks, table, "blocks", "block")
    return [item for block, items in table.items() if block in blocks for item in items]


def fitted_fraction(logs: Logs, validation: Logs | None, fraction: float | None) -> float:
    """Return the fraction of each log's time that is fitted, from its start on.

    Args:
        logs: logs to be fitted.
        validation: logs that are only predicted.
        fraction: fraction that the caller chose, above 0 and at most 1; None: 1, or two thirds without `validation`.

    Raises:
        InputError: there is no log, or the fraction is out of range.
    """
    if not logs:
        raise InputError("there is no log", where="logs", right="give one or more")
    if fraction is not None and not 0.0 < fraction <= 1.0:
        raise InputError(
            f"{fraction:g} is out of range", where="fitted_share", right="give a fraction such as 0.67, or 1 for all"
        )
    return fraction or (1.0 if validation else FITTED_FRACTION)


def insert_columns(described: Described, columns: Mapping[str, Any]) -> Described:
    """Return a description with numbers, or arrays of one item per candidate, at some paths; they are not validated."""
    for path, column in columns.items():
        described = replace_value(described, path.split("."), column)
    return described


def simulate_candidates(
    run: Callable[..., None], count: int, cases: Sequence[tuple[Any, ...]], shapes: Sequence[tuple[int, ...]]
) -> list[Array]:
    """Run every candidate in every case, on all cores.

    Args:
        run: a kernel; it takes the parameters of one candidate, the inputs of a case, and an array for its results.
        count: number of candidates.
        cases: inputs of each case: its parameters (numbers, or arrays with one item per candidate), then its inputs.
        shapes: shapes of each case's results for one candidate.

    Returns:
        Results of each case, (candidates, *shape), NaN where `run` wrote none.
    """
    results = [np.full((count, *shape), np.nan) for shape in shapes]

    def run_job(job: tuple[int, int]) -> None:
        case, i = job
        parameters, *inputs = cases[case]
        run(mapped(parameters, lambda leaf: float(leaf[i] if np.ndim(leaf) else leaf)), *inputs, results[case][i])

    run_on_all_cores(run_job, [(case, i) for case in range(len(cases)) for i in range(count)])
    return results
