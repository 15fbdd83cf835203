"""What the paper's experiments come to over the members of a cloud."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from layflat.experiments.bench import bench
from layflat.experiments.claim import Claim
from layflat.experiments.report import number
from layflat.experiments.reproduction import Reproduction, reproduce
from layflat.files import write_text
from layflat.parallel import process_pool

T = TypeVar("T")

ENDS = (5.0, 95.0)  # percentiles that a spread is told by


@dataclass(frozen=True)
class Spread:
    """One number of a claim over the members of a cloud."""

    claim: str
    quantity: str
    unit: str
    low: float  # 5th percentile
    median: float
    high: float  # 95th percentile
    agreeing: float  # share of the members with which the claim agrees


def claims_of(where: str) -> list[Claim]:
    """Return the claims of a machine by its name, or of a member's."""
    return reproduce(bench(where)).claims


def over(names: Sequence[str]) -> Iterator[list[Claim]]:
    """Yield the claims of machines, on all cores."""
    return at_once(claims_of, names)


def names_in(file: Path, count: int) -> list[str]:
    """Return the names of a cloud's members."""
    return [f"paper-arm@{file}:{number}" for number in range(count)]


def at_once(what: Callable[[str], T], names: Sequence[str]) -> Iterator[T]:
    """Yield something of each machine, on all cores."""
    with process_pool() as submit:
        for job in [submit(what, name) for name in names]:
            yield job.result()


def spreads(found: Sequence[Sequence[Claim]]) -> list[Spread]:
    """Return how each number of each claim spreads over members, whose claims come in the same order."""
    rows = []
    for same in zip(*found, strict=True):
        agreeing = float(np.mean([claim.agrees is True for claim in same]))
        for quantity in same[0].quantities:
            values = np.array([one.value for claim in same for one in claim.quantities if one.name == quantity.name])
            low, median, high = np.percentile(values, [ENDS[0], 50.0, ENDS[1]], method="nearest").tolist()
            rows.append(Spread(same[0].id, quantity.name, quantity.unit, low, median, high, agreeing))
    return rows


def spread_table(found: Reproduction, told: Sequence[Spread]) -> list[list[str]]:
    """Return rows of claim, quantity, what is simulated with the machine itself, spread, unit and share that agrees."""
    own = {(claim.id, one.name): one.value for claim in found.claims for one in claim.quantities}
    rows, before = [], ""
    for one in told:
        first, before = one.claim != before, one.claim
        between = f"{number(one.low)} to {number(one.high)}"
        agreeing = f"{one.agreeing:.0%}" if first else ""
        value = number(own[one.claim, one.quantity])
        rows.append([one.claim if first else "", one.quantity, value, between, one.unit.removeprefix("1"), agreeing])
    return rows


def write_spreads(told: Sequence[Spread], members: int, path: Path) -> Path:
    """Write the spreads over so many members as JSON (OutputError: it can't be written there)."""
    finite = [{key: one if one != np.inf else None for key, one in asdict(row).items()} for row in told]
    return write_text(path, json.dumps({"members": members, "quantities": finite}, indent=2, allow_nan=False) + "\n")
