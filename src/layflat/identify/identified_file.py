"""What was found, as a description that a simulation takes: each value with its interval and the logs it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layflat.description import units as u
from layflat.description.provenance import Provenance, Sources
from layflat.description.tables import Plain
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.identify.benches.hyddown import hyddown_tables, read_hyddown_rig
from layflat.identify.fit import Estimate, Fit
from layflat.machine import Machine
from layflat.machine.derived import at_path, derived_path, with_value, write_derived
from layflat.machine.listing import to_toml
from layflat.machine.loader import tables
from layflat.machine.rigs import Rig, load_described, load_rig, rig_tables

SUFFIX = "identified"

LARGE = 1e7
"""Numbers from here on are written with an exponent."""

DOUBTFUL = "not to be trusted: "
"""Before the title of a description whose fit ran into a bound or came to no end."""


@dataclass(frozen=True)
class Written:
    """A value as it stands in a file, its interval in the same unit, and what was there before.

    Args:
        path: where it stands.
        value: text with its unit, or a number.
        interval: such as "1.98 to 2.01"; empty where it has none.
        before: text, or a number, or None.
        told: whether the log tells it.
        partner: what it can't be told apart from.
        excitation: what would tell it.
        at_bound: whether the search ran into the end of its range.
    """

    path: str
    value: str | float
    interval: str
    before: Any
    told: bool
    partner: str | None
    excitation: str
    at_bound: bool


def identified_path(given: str, described: Machine | Rig, folder: Path) -> Path:
    """Where the description is put.

    Raises:
        InputError: what it begins with can't be extended from there.
    """
    if isinstance(described, Machine):
        return derived_path(given, folder, SUFFIX)
    path = folder / f"{Path(given).stem.removesuffix('.rig')}-{SUFFIX}.toml"
    if path.resolve() == Path(given).resolve():
        raise InputError("would be overwritten, and is what is begun with", where=given, right="give another folder")
    return path


def described_by(given: str) -> Machine | Rig:
    """A machine or a bench from a built-in name or a file; of a vessel also HydDown's input file.

    Raises:
        InputError: in one line, what is wrong with it.
    """
    return read_hyddown_rig(given) if _of_hyddown(given) else load_described(given)


def plain_of(given: str, described: Machine | Rig) -> Plain:
    """The description as it is written."""
    return tables(given)[0] if isinstance(described, Machine) else _rig_tables(given)[0]


def _rig_tables(given: str) -> tuple[Plain, Sources]:
    return (hyddown_tables(given), {}) if _of_hyddown(given) else rig_tables(given)


def _of_hyddown(given: str) -> bool:
    return Path(given).suffix in {".yml", ".yaml"}


def written_values(found: Fit, plain: Plain) -> list[Written]:
    """What was found as it stands in a file, in the units that the description uses."""
    known = {estimate.unknown.path: estimate for estimate in found.estimates}
    return [
        _written(path, value, known.get(path), at_path(plain, path.split(".")))
        for path, value in found.model.written(found.values).items()
    ]


def write_identified(
    given: str, described: Machine | Rig, found: Fit, logs: Mapping[str, str], path: Path
) -> Machine | Rig:
    """Write what was found over a description, and load what was written.

    Args:
        given: built-in name or file of the description.
        described: what it says.
        found: the fit.
        logs: checksums of the fitted logs by name.
        path: from `identified_path`.

    Raises:
        OutputError: it can't be written there.
    """
    plain = plain_of(given, described)
    origin = ", ".join(f"{name} (sha256 {checksum[:16]})" for name, checksum in logs.items())
    rows = written_values(found, plain)
    sources = {row.path: _source(row, origin) for row in rows}
    title = ("" if found.trusted else DOUBTFUL) + f"{described.title}, identified"
    if isinstance(described, Machine):
        return write_derived(given, title, {row.path: row.value for row in rows}, sources, path)
    known = dict(_rig_tables(given)[1])
    for row in rows:
        known[with_value(plain, plain, row.path, row.value)] = sources[row.path]
    with whole_file(path) as temporary:
        temporary.write_text(to_toml(plain | {"name": path.stem, "title": title}, known), encoding="utf-8")
    kept: Rig = load_rig(path)
    return kept


def _source(row: Written, origin: str) -> Provenance:
    interval = f"95 %: {row.interval}; " if row.interval else ""
    if row.told:
        return Provenance("identified", f"{interval}from {origin}")
    why = "at the end of its range" if row.at_bound else "not told"
    return Provenance("assumed", f"{why} by {origin}: fits best; {interval.rstrip('; ') or 'no interval'}")


def _written(path: str, value: float, estimate: Estimate | None, before: Any) -> Written:
    if estimate is None:
        return Written(path, u.alike(before, value, "1"), "", before, True, None, "", False)
    unit = estimate.unknown.unit
    low, high = (_number(u.alike(before, end, unit)) for end in _inside(estimate))
    return Written(
        path,
        u.alike(before, value, unit),
        _interval(low, high),
        before,
        estimate.told,
        estimate.partner,
        estimate.unknown.excitation,
        estimate.at_bound,
    )


def _inside(estimate: Estimate) -> tuple[float, float]:
    """The interval as far as it lies within what was searched: beyond it nothing is known."""
    unknown = estimate.unknown
    return max(estimate.low, unknown.low), min(estimate.high, unknown.high)


def _number(value: str | float) -> float:
    return float(str(value).partition(" ")[0])


def _interval(low: float, high: float) -> str:
    """Both ends with as many digits as it takes to tell them apart."""
    digits = next((n for n in range(3, 9) if f"{low:.{n}g}" != f"{high:.{n}g}"), 9)
    return f"{_plain(low, digits + 1)} to {_plain(high, digits + 1)}"


def _plain(value: float, digits: int) -> str:
    """A number with so many digits, without an exponent where people would write none."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < LARGE else text
