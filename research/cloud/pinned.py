"""Identifiability of the unknowns from the paper's findings: `python -m research.cloud.pinned --out docs/cloud.png`.

Prints a table in Markdown, of each value that is open its range and what the members of the cloud have, and draws it.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import spearmanr

from layflat.arrays import Array
from layflat.machine import load
from layflat.machine.cloud import PAPER_CLOUD
from layflat.machine.exchanged import member_names
from layflat.plot.style import GUIDE_STYLE, SERIES_STYLES, save_figure, styled_figure
from research.calibration.unknowns import Unknown, to_shares, to_values, values_of
from research.cloud.open import GROUPS, built_in_shares

RANGE_PERCENTILES, UNIFORM_RANGE = (
    (5.0, 95.0),
    0.9,
)  # percentiles, and the share of its range between them of what nothing pins down
STRONG_CORRELATION = 0.4  # rank correlation from which two values trade off


@dataclass(frozen=True)
class Pinned:
    """A value that is open, over the members of a cloud; places are shares of its range, counted in factors."""

    unknown: Unknown
    machine: str
    own: float  # where the built-in machine is
    low: float  # 5th percentile
    median: float
    high: float  # 95th percentile
    trades: str  # what it trades off with most, empty if with nothing

    @property
    def covered(self) -> float:
        """Remaining fraction of its range, 1 where nothing constrains it."""
        return min((self.high - self.low) / UNIFORM_RANGE, 1.0)

    def value(self, place: float) -> float:
        """Return the value at a position in its range, in its unit."""
        return float(to_values([self.unknown], np.array([place]))[0])


def shares_of(path: Path = PAPER_CLOUD) -> Array:
    """Return the positions of a cloud's members in the unknowns' ranges, (members, unknowns)."""
    numbers = range(len(member_names("paper-arm", path)))
    parts = []
    for group in GROUPS:
        names = [member_names(group.machine, path)[number] for number in numbers]
        parts.append([to_shares(group.unknowns, values_of(load(name), group.unknowns)) for name in names])
    return np.concatenate(parts, axis=1)


def starts_of(path: Path = PAPER_CLOUD) -> int:
    """Return the number of starts from which a cloud's members come, alternately."""
    return int(json.loads(path.read_text(encoding="utf-8"))["notes"]["starts"])


def pinned(shares: Array, starts: int) -> list[Pinned]:
    """Return what members (members, unknowns) say of every unknown, which come from so many starts in turn.

    What trades off with what is judged among those of one start: those of different ones differ in all at once.
    """
    walks = [shares[start::starts] for start in range(starts)]
    own, correlation = built_in_shares(), np.mean([spearmanr(walk).statistic for walk in walks], axis=0)
    unknowns = [(one, group.machine) for group in GROUPS for one in group.unknowns]
    low, median, high = np.percentile(shares, [RANGE_PERCENTILES[0], 50.0, RANGE_PERCENTILES[1]], axis=0)
    np.fill_diagonal(correlation, 0.0)
    found = []
    for i, (one, machine) in enumerate(unknowns):
        other = int(np.nanargmax(np.abs(correlation[i])))
        how = f"{unknowns[other][0].name} ({correlation[i, other]:+.1f})"
        trades = how if abs(correlation[i, other]) >= STRONG_CORRELATION else ""
        found.append(Pinned(one, machine, own[i], low[i], median[i], high[i], trades))
    return found


def table(found: Sequence[Pinned]) -> str:
    """Return the table in Markdown, the most constrained unknowns first."""
    rows = [
        "| value | range | members, 5 to 95 % | built in | left of the range | trades off with |",
        "|---|---|---|---|---|---|",
    ]
    for one in sorted(found, key=lambda row: row.covered):
        unit, of = (
            f" {one.unknown.unit}" if one.unknown.unit else "",
            f" times {one.unknown.times}" if one.unknown.times else "",
        )
        between = f"{one.value(one.low):.3g} to {one.value(one.high):.3g}"
        limits = f"{one.unknown.low:g} to {one.unknown.high:g}{unit}{of}"
        name = one.unknown.name + (", axis one" if one.machine == "paper-small-joint" else "")
        rows.append(f"| {name} | {limits} | {between} | {one.value(one.own):.3g} | {one.covered:.0%} | {one.trades} |")
    return "\n".join(rows)


def draw(found: Sequence[Pinned]) -> Figure:
    """Draw the distribution of the members in the range of every unknown."""
    rows = sorted(found, key=lambda row: -row.covered)
    with styled_figure(height=0.17 * len(rows) + 0.8, width=7.2, beside=1.6) as (made, (axes,)):
        for at, one in enumerate(rows):
            axes.plot([0.0, 1.0], [at, at], **GUIDE_STYLE)
            axes.plot(
                [one.low, one.high], [at, at], linewidth=4.0, color=SERIES_STYLES[0]["color"], solid_capstyle="butt"
            )
            axes.plot(one.own, at, "o", markersize=4.5, color=SERIES_STYLES[1]["color"], markeredgecolor="white")
        names = [one.unknown.name + (", axis one" if one.machine == "paper-small-joint" else "") for one in rows]
        axes.set_yticks(range(len(rows)), names, fontsize=7.5)
        axes.set_ylim(-0.7, len(rows) - 0.3)
        axes.set_xlim(0.0, 1.0)
        axes.set_xlabel("Place in its range (bars: 5 to 95 % of the members; dots: built in)")
        axes.grid(visible=False, axis="y")
    return made


def effective(walks: Sequence[Array]) -> float:
    """Return how many independent machines places at equal distances of a walk are worth, of the slowest unknown.

    Args:
        walks: shares (machines, unknowns), one after the other.

    The time over which a walk remembers is summed up to five times itself (the window of Sokal, as usual).
    """
    places = np.array(walks) - np.mean(walks, axis=(0, 1))
    count, machines, _ = places.shape
    variance = np.mean(np.square(places), axis=(0, 1))
    memory = np.ones_like(variance)
    growing = np.ones(len(variance), dtype=bool)
    for lag in range(1, count):
        alike = np.mean(places[lag:] * places[:-lag], axis=(0, 1)) / variance
        memory[growing] += 2.0 * alike[growing]
        growing &= lag < 5.0 * memory
        if not growing.any():
            break
    return float(machines * count / np.maximum(memory, 1.0).max())


def main() -> None:
    """Print the table, and draw the figure."""
    asked = argparse.ArgumentParser(prog="python -m research.cloud.pinned", description=__doc__)
    asked.add_argument("--cloud", type=Path, default=PAPER_CLOUD)
    asked.add_argument("--out", type=Path, default=Path("docs/cloud.png"))
    given = asked.parse_args()
    found = pinned(shares_of(given.cloud), starts_of(given.cloud))
    sys.stdout.write(table(found) + "\n")
    save_figure(draw(found), given.out)


if __name__ == "__main__":
    main()
