"""What was found, as a description that a simulation takes: each value with its interval and the logs it comes from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layflat.description import units as u
from layflat.description.provenance import Provenance
from layflat.description.tables import Plain
from layflat.errors import InputError
from layflat.identify.benches.contract import BenchDescription
from layflat.identify.benches.loader import described_tables, load_bench
from layflat.identify.fit import Estimate, Fit
from layflat.identify.holdable import file_texts, holds_another, si_unit
from layflat.machine import Machine
from layflat.machine.listing import at_path, derived_path, to_toml, with_value, write_derived, write_loadable

SUFFIX = "identified"

LARGE = 1e7  # numbers from here on are written with an exponent
ROUNDED = 1e-9  # share of what was searched by which a value may miss its lower bound: 1e-13 N m of friction is none

UNTRUSTED, PARTIAL = "not to be trusted: ", "partial, stopped by the user: "
"""Before the title of a description whose fit hit a bound or did not converge, or was stopped."""


@dataclass(frozen=True)
class Written:
    """A value as it stands in a file, its interval in the same unit, and what was there before."""

    path: str  # where it stands
    value: str | float  # text with its unit, or a number
    interval: str  # such as "1.98 to 2.01"; empty where it has none
    before: Any  # text, or a number, or None
    estimate: Estimate | None  # what was fitted; None of what follows from other values, such as weights
    moved_from: str = ""  # what was found, where no file may hold that: a length of 6e-10 m

    @property
    def identified(self) -> bool:
        """True if the logs identify it."""
        return self.estimate is None or self.estimate.identified

    @property
    def at_bound(self) -> bool:
        """True if it hit its bound."""
        return self.estimate is not None and self.estimate.at_bound


def identified_path(given: str, described: Machine | BenchDescription, folder: Path) -> Path:
    """Return where the description is put; raise InputError if what it begins with can't be extended from there."""
    if isinstance(described, Machine):
        return derived_path(given, folder, SUFFIX)
    path = folder / f"{Path(given).stem.removesuffix('.rig')}-{SUFFIX}.toml"
    if path.resolve() == Path(given).resolve():
        raise InputError("would be overwritten, and is what is begun with", where=given, right="give another folder")
    return path


def written_values(found: Fit, described: Machine | BenchDescription, plain: Plain) -> list[Written]:
    """Return what was found as it stands in a file, or would if the values could stand there together.

    Args:
        found: the fit.
        described: the description that holds the values.
        plain: texts that stand there before; new ones have their units.
    """
    known = {estimate.unknown.path: estimate for estimate in found.estimates}
    values = {path: _rounded(value, known.get(path)) for path, value in found.model.written(found.values).items()}
    before = {path: at_path(plain, path.split(".")) for path in values}
    try:
        texts = file_texts(described, values, before)
    except InputError:  # these values are reported even so; a file refuses them
        texts = {path: u.alike(before[path], value, si_unit(described, path)) for path, value in values.items()}
    return [_written(described, path, values[path], texts[path], known.get(path), before[path]) for path in values]


def write_identified(
    given: str,
    described: Machine | BenchDescription,
    found: Fit,
    logs: Mapping[str, str],
    path: Path,
    replaces: Mapping[str, Any] | None = None,
) -> Machine | BenchDescription:
    """Write what was found over a description, and load what was written.

    Args:
        given: built-in name or file of the description.
        described: what holds the values that were found.
        found: the fit.
        logs: checksums of the fitted logs by name.
        path: from `identified_path`.
        replaces: whole parts of a machine that stand there instead, by path.

    Raises:
        InputError: what was found can't be held by a description, or can't be written there.
    """
    plain, known = described_tables(given)
    origin = ", ".join(f"{name} (sha256 {checksum[:16]})" for name, checksum in logs.items())
    rows = written_values(found, described, plain)
    sources = _sources(rows, origin)
    title = f"{PARTIAL if found.partial else '' if found.trusted else UNTRUSTED}{described.title}, identified"
    if isinstance(described, Machine):
        whole = dict(replaces or {})
        sources |= {part: Provenance("identified", f"the kind that predicts best, from {origin}") for part in whole}
        return write_derived(given, title, whole | {row.path: row.value for row in rows}, sources, path)
    for row in rows:
        known[with_value(plain, plain, row.path, row.value)] = sources[row.path]
    kept: BenchDescription = write_loadable(
        path, to_toml(plain | {"name": path.stem, "title": title}, known), load_bench
    )
    return kept


def _sources(rows: Sequence[Written], origin: str) -> dict[str, Provenance]:
    """Return the source of every value by its path; those of a list, which has one source, have the same."""
    lists: dict[str, list[Written]] = {}
    for row in rows:
        parent, _, item = row.path.rpartition(".")
        lists.setdefault(parent if item.isdigit() else row.path, []).append(row)
    return {row.path: _source(together, origin) for together in lists.values() for row in together}


def _source(rows: Sequence[Written], origin: str) -> Provenance:
    intervals = ", ".join(row.interval for row in rows if row.interval)
    interval = f"95 %: {intervals}; " if intervals else ""
    moved = ", ".join(row.moved_from for row in rows if row.moved_from)
    past = f"; found was {moved}, which no description holds" if moved else ""
    if all(row.identified for row in rows):
        return Provenance("identified", f"{interval}from {origin}{past}")
    sure = sum(row.identified for row in rows)
    some = f"only {sure} of {len(rows)} identifiable" if sure else "not identifiable"
    why = "at its bound" if any(row.at_bound for row in rows) else some
    return Provenance("assumed", f"{why} from {origin}: best fit; {interval.rstrip('; ') or 'no interval'}{past}")


def _rounded(value: float, estimate: Estimate | None) -> float:
    """A value found, or its lower bound where it misses that by rounding alone."""
    if estimate is None:
        return value
    low, high = estimate.unknown.low, estimate.unknown.high
    return low if abs(value - low) < ROUNDED * (high - low) else value


def _written(
    described: Machine | BenchDescription,
    path: str,
    value: float,
    text: str | float,
    estimate: Estimate | None,
    before: Any,
) -> Written:
    unit = si_unit(described, path)
    moved = str(u.alike(before, value, unit)) if holds_another(described, path, text, value) else ""
    if estimate is None:
        return Written(path, text, "", before, None, moved)
    unknown = estimate.unknown
    # The interval as far as it lies within what was searched: beyond it nothing is known.
    ends = max(estimate.low, unknown.low), min(estimate.high, unknown.high)
    low, high = (float(str(u.alike(before, end, unit)).partition(" ")[0]) for end in ends)
    return Written(path, text, _interval(low, high), before, estimate, moved)


def _interval(low: float, high: float) -> str:
    """Both ends with as many digits as it takes to tell them apart."""
    digits = next((n for n in range(3, 9) if f"{low:.{n}g}" != f"{high:.{n}g}"), 9)
    return f"{_plain(low, digits + 1)} to {_plain(high, digits + 1)}"


def _plain(value: float, digits: int) -> str:
    """A number with so many digits, without an exponent where people would write none."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < LARGE else text
