"""Mass and cost of a study's machines as they would be built: from sizes by rules, without solids."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layflat.description.change import changed_all
from layflat.errors import DesignError, InputError
from layflat.jit.cache import source_digest

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from layflat.arrays import Array
    from layflat.machine import Machine
    from layflat.solids.cost import Prices

BUILT_UNITS = {"mass_built": "kg", "cost": "1"}
"""Units of what a machine has once it is built, by its name among the metrics; a cost is in the prices' currency."""


def _built_values(machine: Machine, prices: Prices | None) -> dict[str, float]:
    """Return the values of `BUILT_UNITS` of a machine, a cost only with prices."""
    from layflat.solids.totals import built_totals  # noqa: PLC0415  # most studies build nothing

    return dict(zip(BUILT_UNITS, built_totals(machine, prices), strict=True))


def rules_digest() -> str:
    """Return a digest of the source of all that sizes what is built."""
    from layflat.solids import totals  # noqa: PLC0415  # as above

    return source_digest(Path(totals.__file__))


def check_built(machine: Machine, prices: Prices | None, metrics: Sequence[str], where: str) -> None:
    """Refuse metrics that a machine does not have, or that lack prices.

    Args:
        machine: machine of the study.
        prices: prices of the study, if it has any.
        metrics: names of the chosen metrics.
        where: the file, for messages.

    Raises:
        InputError: naming the key.
    """
    if ("cost" in metrics) != (prices is not None):
        if prices is not None:
            raise InputError("has no effect", where=f"{where}: prices", right='add "cost" to metrics, or leave it out')
        right = 'name a file, such as prices = "prices.toml"'
        raise InputError('"cost" needs prices', where=f"{where}: metrics", right=right)
    wanted = [name for name in metrics if name in BUILT_UNITS]
    if wanted:
        try:
            _built_values(machine, prices)
        except DesignError as error:
            what = f"{wanted[0]!r} needs a machine that can be built: {error.what}"
            raise InputError(what, where=f"{where}: metrics", right=error.right) from None


def built_columns(
    machine: Machine, values: Mapping[str, Array], metrics: Sequence[str], prices: Prices | None
) -> Iterator[tuple[str, Array, str]]:
    """Yield name, values and unit of what a study asks of built machines; not a number where none can be built.

    Args:
        machine: machine of the study.
        values: what to set on it and other values of each row, (rows,) by path (SI).
        metrics: names of the chosen metrics.
        prices: prices of the study, if it has any.
    """
    wanted = [name for name in metrics if name in BUILT_UNITS]
    if not wanted:
        return
    # Scenarios change nothing that is built.
    paths = [path for path in values if path.partition(".")[0] not in {"scenario", "seed"}]

    @cache
    def build(*numbers: float) -> dict[str, float]:
        changes = dict(zip(paths, numbers, strict=True))
        try:
            return _built_values(changed_all(machine, changes), prices)
        except DesignError:
            return dict.fromkeys(BUILT_UNITS, float("nan"))

    rows = zip(*(values[path].tolist() for path in paths), strict=True) if paths else [()] * len(values["seed"])
    found = [build(*row) for row in rows]
    for name in wanted:
        yield name, np.array([one[name] for one in found]), BUILT_UNITS[name]
