"""A parameter to be identified."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Unknown:
    """A parameter to be identified.

    Args:
        path: where it stands in the description, "valve.conductance"; a nuisance begins with "start." or "log.".
        unit: SI, for tables.
        guess: where the search begins.
        low: least value.
        high: greatest value.
        log: whether it is searched on a logarithmic scale; then `low` is above zero.
        excitation: what a log has to contain to identify it, in one clause.
        nuisance: whether it is fitted only because the rest depends on it, as the state that a log begins in.
        floor: whether the lower bound is physical, such as zero delay, where a value may well lie.
    """

    path: str
    unit: str
    guess: float
    low: float
    high: float
    log: bool = True
    excitation: str = ""
    nuisance: bool = False
    floor: bool = False
