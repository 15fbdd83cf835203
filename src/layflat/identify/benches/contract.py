"""What every kind of test bench provides: a description that a file holds, and a model of its logs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from layflat.description import Part
from layflat.description.names import Name
from layflat.errors import InputError
from layflat.identify.model import FITTED, Model

if TYPE_CHECKING:
    import xarray

Logs: TypeAlias = "Mapping[str, xarray.Dataset]"


class BenchDescription(Part):
    """A test bench that is not a machine of ours; the `kind` at the top of its file says which."""

    kind: str
    name: Name
    title: str


class Bench(NamedTuple):
    """How the logs of a kind of bench are fitted.

    `model` takes the description, the logs to fit, the logs for validation, and the `blocks`. Logs are `even` where a
    simulation steps through them; otherwise every sample stays at its own stamp.
    """

    blocks: Sequence[str]
    default_blocks: Sequence[str]
    model: Callable[..., Model]
    even: bool


def has_samples(log: xarray.Dataset, signal: str, joint: str) -> bool:
    """Whether a log has any sample of a joint's signal."""
    if signal not in log or ("joint" in log[signal].dims and joint not in log["joint"].values):
        return False
    values = log[signal].sel(joint=joint) if "joint" in log[signal].dims else log[signal]
    return bool(values.notnull().any())


def require_samples(logs: Logs, signals: Sequence[str], joints: Sequence[str]) -> None:
    """Refuse logs that lack a signal of a joint.

    Raises:
        InputError: naming the first log, signal and joint.
    """
    for name, signal, joint in product(logs, signals, joints):
        if not has_samples(logs[name], signal, joint):
            of = f" of every joint: {', '.join(joints)}" if len(joints) > 1 else ""
            raise InputError(
                f"has no {signal} of joint {joint!r}", where=name, right=f"map a column to the signal {signal}{of}"
            )


def check_known(given: Collection[str], known: Collection[str], where: str, what: str) -> list[str]:
    """Each name once, if all of them are known.

    Raises:
        InputError: naming the first that is not.
    """
    unknown = [name for name in given if name not in known]
    if unknown:
        raise InputError(f"unknown {what} {unknown[0]!r}", where=where, right=f"choose from {', '.join(known)}")
    return list(dict.fromkeys(given))


def fitted_share_of(logs: Logs, validation: Logs | None, share: float | None) -> float:
    """Share of each log's time, from its start, that is fitted: all of it where others are there for validation.

    Raises:
        InputError: there is no log, or the share is out of range.
    """
    if not logs:
        raise InputError("there is none", where="logs", right="give one or more")
    if share is not None and not 0.0 < share <= 1.0:
        raise InputError(f"{share:g} is out of range", where="fitted_share", right="give 0.67, or 1 for all")
    return share or (1.0 if validation else FITTED)
