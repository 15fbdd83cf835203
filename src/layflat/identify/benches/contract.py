"""What every kind of test bench provides: a description that a file holds, and a model of its logs."""

from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description import Part
from layflat.description.change import replaced
from layflat.description.names import Name
from layflat.errors import InputError
from layflat.identify.model import FITTED, Model
from layflat.lanes import mapped
from layflat.parallel import on_all_cores

Logs = Mapping[str, Dataset]  # by name
T = TypeVar("T")
Described = TypeVar("Described", bound=Part)


class BenchDescription(Part):
    """A test bench that is not a machine of ours; the `kind` at the top of its file says which."""

    kind: str
    name: Name
    title: str


def no_kinds(described: Any, logs: Logs, blocks: Sequence[str]) -> Mapping[str, tuple[Any, Mapping[str, Any]]]:  # noqa: ARG001
    """Of most benches there is one law."""
    return {}


class Bench(NamedTuple):
    """How the logs of a kind of bench are fitted.

    A model is made of a description (where the search begins, and what is held), the logs to fit, the logs for
    validation, which are only predicted (without any, the last third of each log is), and the `blocks` to fit. It
    raises InputError if a log lacks a signal that it needs, or a block is unknown.
    """

    blocks: Sequence[str]
    default_blocks: Sequence[str]
    model: Callable[..., Model]
    even: bool  # logs are those that a simulation steps through; otherwise every sample stays at its own stamp
    kinds: Callable[..., Mapping[str, tuple[Any, Mapping[str, Any]]]] = no_kinds
    """Descriptions with other laws that the logs are compared by, of a description, logs and blocks: by name, the
    simplest first, each with the whole parts that it replaces. None: logs are fitted by the description's own law."""


def has_samples(log: Dataset, signal: str, joint: str) -> bool:
    """Whether a log has any sample of a joint's signal."""
    if signal not in log or ("joint" in log[signal].dims and joint not in log["joint"].values):
        return False
    values = log[signal].sel(joint=joint) if "joint" in log[signal].dims else log[signal]
    return bool(values.notnull().any())


def require_samples(logs: Logs, signals: Sequence[str], joints: Sequence[str]) -> None:
    """Raise InputError if a log lacks a signal of a joint, naming the first of each."""
    for name, signal, joint in product(logs, signals, joints):
        if not has_samples(logs[name], signal, joint):
            of = f" of every joint: {', '.join(joints)}" if len(joints) > 1 else ""
            right = f"map a column to the signal {signal}{of}"
            raise InputError(f"has no {signal} of joint {joint!r}", where=name, right=right)


def check_known(given: Collection[str], known: Collection[str], where: str, what: str) -> list[str]:
    """Each name once; raise InputError if one is not known."""
    unknown = [name for name in given if name not in known]
    if unknown:
        raise InputError(f"unknown {what} {unknown[0]!r}", where=where, right=f"choose from {', '.join(known)}")
    return list(dict.fromkeys(given))


def chosen(table: Mapping[str, Sequence[T]], blocks: Collection[str]) -> list[T]:
    """What a table has for the chosen blocks, in its own order; raise InputError if it lacks one."""
    check_known(blocks, table, "blocks", "block")
    return [one for block, of in table.items() if block in blocks for one in of]


def fitted_share_of(logs: Logs, validation: Logs | None, share: float | None) -> float:
    """Share of each log's time that is fitted, from its start on; raise InputError without a log, or out of range."""
    if not logs:
        raise InputError("there is none", where="logs", right="give one or more")
    if share is not None and not 0.0 < share <= 1.0:
        raise InputError(f"{share:g} is out of range", where="fitted_share", right="give 0.67, or 1 for all")
    return share or (1.0 if validation else FITTED)


def with_columns(described: Described, found: Mapping[str, Any]) -> Described:
    """A description with numbers, or arrays of an item a candidate, at some paths; unchecked, as a search goes far."""
    for path, column in found.items():
        described = replaced(described, path.split("."), column)
    return described


def simulated(
    run: Callable[..., None], count: int, cases: Sequence[tuple[Any, ...]], shapes: Sequence[tuple[int, ...]]
) -> list[Array]:
    """Run every candidate in every case, on all cores.

    Args:
        run: a kernel; it takes the parameters of one candidate, what is given of a case, and room for its results.
        count: of candidates.
        cases: of each its parameters (numbers, or arrays with an item a candidate), then what is given of it.
        shapes: of the room of each case.

    Returns:
        Results of each case, (candidates, *shape), not numbers where `run` wrote none.
    """
    rooms = [np.full((count, *shape), np.nan) for shape in shapes]

    def work(job: tuple[int, int]) -> None:
        case, i = job
        parameters, *given = cases[case]
        run(mapped(parameters, lambda leaf: float(leaf[i] if np.ndim(leaf) else leaf)), *given, rooms[case][i])

    on_all_cores(work, [(case, i) for case in range(len(cases)) for i in range(count)])
    return rooms
