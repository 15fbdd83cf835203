"""Results of a fit as a description file: each value with its interval and the logs of its origin.

A description file holds values within the range of their quantity and the bounds of their key.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import copysign, isfinite
from pathlib import Path
from typing import Any, get_args

from annotated_types import Ge, Gt, Le, Lt

from layflat.description import Part
from layflat.description import units as u
from layflat.description.change import annotation_at, changed_all, quantity_of, value_at
from layflat.description.tables import Plain, Provenance
from layflat.errors import InputError
from layflat.identify.benches import BenchDescription
from layflat.identify.benches.loader import description_tables, load_bench
from layflat.identify.fit import Fit, FittedParameter
from layflat.machine import Machine
from layflat.machine.listing import derived_path, nested_value, set_nested_value, to_toml, write_derived, write_loadable

DIGITS = (7, 17)  # significant digits of a number in a file; all of them where rounding breaks a rule
INWARD_SHIFTS = (0.0, 1e-6, 1e-5)  # relative shifts away from a bound, for texts that round beyond it
SAME_VALUE_TOLERANCE = 1e-6  # relative difference of a text that is rounding


def format_values(described: Part, values: Mapping[str, float], before: Mapping[str, Any]) -> dict[str, str | float]:
    """Return values as texts that a file of this description accepts, each alone and all together.

    A magnitude outside the range of its quantity, such as a length of 6e-10 m, is written as the nearest allowed one,
    or as zero where that is allowed.

    Args:
        described: the description that holds the values.
        values: values by dotted path, SI.
        before: present texts or numbers, by path: each new text has the unit of the present one.

    Returns:
        Texts with units, or numbers where the quantity has none, by path.

    Raises:
        InputError: the values contradict each other, such as a stop inside the sensor's range.
    """
    refused: InputError | None = None
    for digits in DIGITS:
        texts = {path: format_value(described, path, value, before.get(path), digits) for path, value in values.items()}
        try:
            changed_all(described, texts)
        except InputError as error:
            refused = error
        else:
            return texts
    assert refused is not None
    raise refused


def holds_other_value(described: Part, path: str, text: str | float, value: float) -> bool:
    """Return whether a text at a path holds another value than this one (SI), beyond rounding; False if it is refused.

    Args:
        described: the description.
        path: dotted.
        text: text with its unit, or a plain number.
        value: SI.
    """
    try:
        stored = float(value_at(changed_all(described, {path: text}, together=False), path))
    except InputError:  # no valid value
        return False
    return abs(stored - value) > SAME_VALUE_TOLERANCE * max(abs(value), abs(stored))


def si_unit(described: Part, path: str) -> str:
    """Return the SI unit of the value at a path; "1" for a plain number."""
    quantity = quantity_of(annotation_at(described, path))
    return quantity.unit if quantity else "1"


def format_value(described: Part, path: str, value: float, before: Any, digits: int = DIGITS[0]) -> str | float:
    """Return one value (SI) as a text that its key accepts: see `format_values`.

    Args:
        described: the description.
        path: dotted.
        value: SI.
        before: present text or number, or None.
        digits: significant, of the number.

    Raises:
        InputError: the key accepts no value near it.
    """
    refused: InputError | None = None
    for candidate in _allowed_values(annotation_at(described, path), value):
        text = u.quantity_text(before, candidate, si_unit(described, path), digits)
        try:
            changed_all(described, {path: text}, together=False)
        except InputError as error:
            refused = error
        else:
            return text
    assert refused is not None
    raise refused


def _allowed_values(annotation: Any, value: float) -> Iterator[float]:
    """Yield candidates near a value: 0 where it is too small, the value within its bounds, then it shifted a little.

    A value that is not finite is the only candidate.
    """
    if not isfinite(value):
        yield value
        return
    notes = get_args(annotation)[1:]
    quantity = quantity_of(annotation)
    smallest, greatest = (quantity.least, quantity.most) if quantity else (0.0, float("inf"))
    value += 0.0  # no negative zero
    lowest = [
        float(getattr(bound, "ge" if isinstance(bound, Ge) else "gt")) for bound in notes if isinstance(bound, (Ge, Gt))
    ]
    highest = [
        float(getattr(bound, "le" if isinstance(bound, Le) else "lt")) for bound in notes if isinstance(bound, (Le, Lt))
    ]
    inside = min(max(value, *lowest, -greatest), *highest, greatest)
    if 0.0 < abs(inside) < smallest:
        yield 0.0
    # For an exclusive bound, or a text that rounds beyond it: shifted a little, up or down.
    small = max(smallest, 1e-12)
    for shift, direction in product(INWARD_SHIFTS, (1.0, -1.0)):
        shifted = inside + direction * shift * max(abs(inside), small)
        yield copysign(max(abs(shifted), smallest), shifted) if shifted != 0.0 else 0.0
    yield from (small, -small)


SUFFIX = "identified"

MIN_EXPONENT_VALUE = 1e7  # numbers from this on are written with an exponent
BOUND_ROUNDING = 1e-9  # of the searched range: a value so close to its lower bound is that, as 1e-13 N m of friction

UNTRUSTED_PREFIX, PARTIAL_PREFIX = "not to be trusted: ", "partial, stopped by the user: "
"""Prefix of a description's title if its fit hit a bound or did not converge, or was stopped."""


@dataclass(frozen=True)
class WrittenValue:
    """Value in a description file, its interval in the same unit, and the previous value."""

    path: str  # dotted, in the description
    value: str | float  # text with its unit, or a number
    interval: str  # such as "1.98 to 2.01"; empty where it has none
    before: Any  # text, or a number, or None
    estimate: FittedParameter | None  # None for a value that follows from fitted ones, such as weights
    moved_from: str = ""  # fitted value where a file can't hold it, such as a length of 6e-10 m; else ""

    @property
    def identified(self) -> bool:
        """True if the logs identify the value, or it follows from fitted ones."""
        return self.estimate is None or self.estimate.identified

    @property
    def at_bound(self) -> bool:
        """True if the fit hit a bound of its range."""
        return self.estimate is not None and self.estimate.at_bound


def identified_path(source: str, described: Machine | BenchDescription, folder: Path) -> Path:
    """Return the path of the fitted description: NAME-identified.toml in the folder.

    NAME is a machine's name, or that of a bench's source without ".rig" and suffix.

    Args:
        source: built-in name or file of the first description.
        described: its content.
        folder: folder for the results.

    Raises:
        InputError: it would overwrite the first description or, of a machine, a file that this extends.
    """
    if isinstance(described, Machine):
        return derived_path(source, folder, SUFFIX)
    path = folder / f"{Path(source).stem.removesuffix('.rig')}-{SUFFIX}.toml"
    if path.resolve() == Path(source).resolve():
        raise InputError(
            "is the description to begin with, and would be overwritten", where=source, right="give another folder"
        )
    return path


def written_values(fit: Fit, described: Machine | BenchDescription, plain: Plain) -> list[WrittenValue]:
    """Return the fitted values as texts of a file, even where a file would refuse them together.

    Args:
        fit: fit with the values.
        described: description that holds them.
        plain: present tables of the description; new texts have their units.
    """
    estimate_by_path = {estimate.unknown.path: estimate for estimate in fit.estimates}
    values = {
        path: _snap_to_bound(value, estimate_by_path.get(path))
        for path, value in fit.model.described_values(fit.values).items()
    }
    before = {path: nested_value(plain, path.split(".")) for path in values}
    try:
        texts = format_values(described, values, before)
    except InputError:  # these values are reported even so; a file refuses them
        texts = {path: u.quantity_text(before[path], value, si_unit(described, path)) for path, value in values.items()}
    return [
        _written_value(described, path, values[path], texts[path], estimate_by_path.get(path), before[path])
        for path in values
    ]


def write_identified(
    source: str,
    described: Machine | BenchDescription,
    fit: Fit,
    logs: Mapping[str, str],
    path: Path,
    replaces: Mapping[str, Any] | None = None,
) -> Machine | BenchDescription:
    """Write a description with the fitted values, and return it as loaded again.

    Args:
        source: built-in name or file of the first description.
        described: description with the law of the fit.
        fit: fit with the values.
        logs: checksums of the fitted logs by name.
        path: path from `identified_path`.
        replaces: whole parts that replace those of a machine, by path.

    Raises:
        InputError: a description can't hold the values.
        OutputError: it can't be written there.
    """
    plain, value_sources = description_tables(source)
    origin = ", ".join(f"{name} (sha256 {checksum[:16]})" for name, checksum in logs.items())
    rows = written_values(fit, described, plain)
    sources = _value_sources(rows, origin)
    title = f"{PARTIAL_PREFIX if fit.partial else '' if fit.trusted else UNTRUSTED_PREFIX}{described.title}, identified"
    if isinstance(described, Machine):
        parts = dict(replaces or {})
        sources |= {part: Provenance("identified", f"the kind that predicts best, from {origin}") for part in parts}
        return write_derived(source, title, parts | {row.path: row.value for row in rows}, sources, path)
    for row in rows:
        value_sources[set_nested_value(plain, plain, row.path, row.value)] = sources[row.path]
    loaded: BenchDescription = write_loadable(
        path, to_toml(plain | {"name": path.stem, "title": title}, value_sources), load_bench
    )
    return loaded


def _value_sources(rows: Sequence[WrittenValue], origin: str) -> dict[str, Provenance]:
    """Return the provenance of every value by path; all items of a list have the same."""
    lists: dict[str, list[WrittenValue]] = {}
    for row in rows:
        parent, _, item = row.path.rpartition(".")
        lists.setdefault(parent if item.isdigit() else row.path, []).append(row)
    return {row.path: _value_provenance(together, origin) for together in lists.values() for row in together}


def _value_provenance(rows: Sequence[WrittenValue], origin: str) -> Provenance:
    """Return the common provenance of values: "identified" if the logs identify all of them, else "assumed"."""
    intervals = ", ".join(row.interval for row in rows if row.interval)
    interval = f"95 %: {intervals}; " if intervals else ""
    fitted = ", ".join(row.moved_from for row in rows if row.moved_from)
    past = f"; found was {fitted}, which no description holds" if fitted else ""
    if all(row.identified for row in rows):
        return Provenance("identified", f"{interval}from {origin}{past}")
    identified = sum(row.identified for row in rows)
    uncertainty = f"only {identified} of {len(rows)} identifiable" if identified else "not identifiable"
    why = "at its bound" if any(row.at_bound for row in rows) else uncertainty
    return Provenance("assumed", f"{why} from {origin}: best fit; {interval.rstrip('; ') or 'no interval'}{past}")


def _snap_to_bound(value: float, estimate: FittedParameter | None) -> float:
    """Return a fitted value, or its lower bound where it differs from that by rounding alone."""
    if estimate is None:
        return value
    low, high = estimate.unknown.low, estimate.unknown.high
    return low if abs(value - low) < BOUND_ROUNDING * (high - low) else value


def _written_value(
    described: Machine | BenchDescription,
    path: str,
    value: float,
    text: str | float,
    estimate: FittedParameter | None,
    before: Any,
) -> WrittenValue:
    """Return one value as it stands in a file, and its interval, cut to the searched range, in the same unit."""
    unit = si_unit(described, path)
    fitted = str(u.quantity_text(before, value, unit)) if holds_other_value(described, path, text, value) else ""
    if estimate is None:
        return WrittenValue(path, text, "", before, None, fitted)
    unknown = estimate.unknown
    # The interval within the searched range: beyond it nothing is known.
    ends = max(estimate.low, unknown.low), min(estimate.high, unknown.high)
    low, high = (float(str(u.quantity_text(before, end, unit)).partition(" ")[0]) for end in ends)
    return WrittenValue(path, text, _format_interval(low, high), before, estimate, fitted)


def _format_interval(low: float, high: float) -> str:
    """Return an interval as text, with enough digits to distinguish its ends."""
    digits = next((n for n in range(3, 9) if f"{low:.{n}g}" != f"{high:.{n}g}"), 9)
    return f"{_format_number(low, digits + 1)} to {_format_number(high, digits + 1)}"


def _format_number(value: float, digits: int) -> str:
    """Return a number with some significant digits, without an exponent below `MIN_EXPONENT_VALUE`."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < MIN_EXPONENT_VALUE else text
