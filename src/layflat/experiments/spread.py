"""Range of each number of the paper's claims over the members of a cloud (plausible parameter sets)."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from layflat.experiments.bench import load_bench
from layflat.experiments.claim import Claim
from layflat.experiments.report import format_number
from layflat.experiments.reproduction import Reproduction, reproduce
from layflat.files import write_text
from layflat.parallel import process_pool

T = TypeVar("T")

RANGE_PERCENTILES = (5.0, 95.0)  # lower and upper end of a range


@dataclass(frozen=True)
class QuantityRange:
    """Range of one number of a claim over the members of a cloud."""

    claim: str
    quantity: str
    unit: str
    low: float  # 5th percentile
    median: float
    high: float  # 95th percentile
    agreeing: float  # fraction of the members with which the claim agrees


def evaluate_claims(where: str) -> list[Claim]:
    """Return the evaluated claims of a built-in machine or a cloud's member, by its name."""
    return reproduce(load_bench(where)).claims


def evaluate_machines(names: Sequence[str]) -> Iterator[list[Claim]]:
    """Yield the evaluated claims of each machine, on all cores."""
    return map_in_processes(evaluate_claims, names)


def cloud_file_members(file: Path, count: int) -> list[str]:
    """Return the loadable names of the members in a cloud's file: "paper-arm@FILE:0", ..."""
    return [f"paper-arm@{file}:{number}" for number in range(count)]


def map_in_processes(function: Callable[[str], T], names: Sequence[str]) -> Iterator[T]:
    """Yield the result of a function of each machine's name, in order, on all cores."""
    with process_pool() as submit:
        for job in [submit(function, name) for name in names]:
            yield job.result()


def quantity_ranges(claims_by_member: Sequence[Sequence[Claim]]) -> list[QuantityRange]:
    """Return the range of each number of each claim, as of the first member, over members with the same claims."""
    rows = []
    for member_claims in zip(*claims_by_member, strict=True):
        agreeing = float(np.mean([claim.agrees is True for claim in member_claims]))
        for quantity in member_claims[0].quantities:
            values = np.array(
                [one.value for claim in member_claims for one in claim.quantities if one.name == quantity.name]
            )
            low, median, high = np.percentile(
                values, [RANGE_PERCENTILES[0], 50.0, RANGE_PERCENTILES[1]], method="nearest"
            ).tolist()
            rows.append(QuantityRange(member_claims[0].id, quantity.name, quantity.unit, low, median, high, agreeing))
    return rows


def range_rows(reproduction: Reproduction, ranges: Sequence[QuantityRange]) -> list[list[str]]:
    """Return table rows: claim, quantity, value of the machine itself, range, unit and fraction that agrees."""
    values = {(claim.id, row.name): row.value for claim in reproduction.claims for row in claim.quantities}
    rows, last_claim = [], ""
    for row in ranges:
        first, last_claim = row.claim != last_claim, row.claim
        between = f"{format_number(row.low)} to {format_number(row.high)}"
        agreeing = f"{row.agreeing:.0%}" if first else ""
        value = format_number(values[row.claim, row.quantity])
        rows.append([row.claim if first else "", row.quantity, value, between, row.unit.removeprefix("1"), agreeing])
    return rows


def write_ranges(ranges: Sequence[QuantityRange], members: int, path: Path) -> Path:
    """Write ranges as JSON, an infinite number as null, and return the path.

    Args:
        ranges: ranges of the claims' numbers.
        members: number of members of the cloud.
        path: path of the file.

    Raises:
        OutputError: the file can't be written.
    """
    finite = [{key: cell if cell != np.inf else None for key, cell in asdict(row).items()} for row in ranges]
    return write_text(path, json.dumps({"members": members, "quantities": finite}, indent=2, allow_nan=False) + "\n")
