"""What every kind of test bench provides: a description that a file holds, and a model of its logs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from layflat.description import Part
from layflat.description.names import Name
from layflat.errors import InputError
from layflat.identify.model import Model

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

    `model` takes the description, the logs to fit, the blocks, and the logs for validation. Logs are `even` where a
    simulation steps through them; otherwise every sample stays at its own stamp.
    """

    blocks: Sequence[str]
    default_blocks: Sequence[str]
    model: Callable[[Any, Logs, Sequence[str], Logs], Model]
    even: bool


def has_samples(log: xarray.Dataset, signal: str, joint: str) -> bool:
    """Whether a log has any sample of a joint's signal."""
    if signal not in log or ("joint" in log[signal].dims and joint not in log["joint"].values):
        return False
    values = log[signal].sel(joint=joint) if "joint" in log[signal].dims else log[signal]
    return bool(values.notnull().any())


def check_known(given: Collection[str], known: Collection[str], where: str, what: str) -> list[str]:
    """Each name once, if all of them are known.

    Raises:
        InputError: naming the first that is not.
    """
    unknown = [name for name in given if name not in known]
    if unknown:
        raise InputError(f"unknown {what} {unknown[0]!r}", where=where, right=f"choose from {', '.join(known)}")
    return list(dict.fromkeys(given))


def check_logs(logs: Collection[str], validation: Collection[str], fitted_share: float) -> None:
    """Refuse what can't be fitted.

    Raises:
        InputError: there is no log, a log for validation is unknown, or the share is out of range.
    """
    if not logs:
        raise InputError("there is none", where="logs", right="give one or more")
    check_known(validation, logs, "validation", "log")
    if not 0.0 < fitted_share <= 1.0:
        raise InputError(f"{fitted_share:g} is out of range", where="fitted_share", right="give 0.67, or 1 for all")
