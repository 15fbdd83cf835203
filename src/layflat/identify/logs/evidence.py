"""Evidence for a column being a signal: its name, its unit, and whether its values can be such."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.identify.logs.headers import words_of
from layflat.identify.logs.mapping import SENSED
from layflat.identify.logs.table import Column, Table
from layflat.identify.logs.units import kind_of_unit, measures
from layflat.identify.logs.vocabulary import (
    FILTERED,
    FORCE,
    RAW,
    SIGNALS,
    STATISTICS,
    Signal,
    conversion,
    meanings,
    signal_of,
)

BY_UNIT = {"rad": "angle", "Pa": "pressure", "V": "voltage", "N*m": "torque", "N": "force", "K": "temperature"}
"""Roles, and signals, that a unit alone tells, by its SI unit."""

POSSIBLE: dict[u.Quantity, tuple[float, float]] = {
    u.PRESSURE: (100.0, 1e8), u.ANGLE: (0.0, 4.0 * np.pi), u.VOLTAGE: (0.0, 1e3), u.TORQUE: (0.0, 1e5),
    FORCE: (0.0, 1e7), u.TEMPERATURE: (60.0, 2e3), u.LENGTH: (0.0, 100.0), u.MASS: (0.0, 1e4),
}  # fmt: skip
"""Range of the greatest magnitude of a signal that moves, SI: outside it a stated unit can't be."""

RANGES: dict[u.Quantity, tuple[tuple[float, str], ...]] = {
    u.ANGLE: ((3.5, "rad"), (7.0, ""), (np.inf, "deg")),  # neither a few degrees nor a whole turn is usual
    u.PRESSURE: ((20.0, "bar"), (160.0, "psi"), (5e3, "kPa"), (np.inf, "Pa")),
    u.VOLTAGE: ((30.0, "V"), (np.inf, "mV")),
    u.TEMPERATURE: ((150.0, "degC"), (np.inf, "K")),
    u.LENGTH: ((2.0, "m"), (np.inf, "mm")),
}
"""Units by the greatest value that would be likely in them."""

_CHANNELS = "ch chan channel kanal canal ai ain ao aout analog adc dac dev input port slot module"
CHANNELS = frozenset(_CHANNELS.split())
"""Words before the number of a recorder's channel, which is neither a joint's nor a hose's."""

QUANTITIES = frozenset(["pressure", "angle", "torque", "force", "temperature", "position", "brake"])
"""Roles beside which "current" is the present value."""

COUNTS = frozenset(["counts", "dac", "adc", "pwm", "lsb", "digit", "digits", "bits", "inc", "incr", "increments"])
"""Words of numbers that are no quantity before their scale."""

LEAST_COUNT = 200.0  # from which whole numbers may be counts of a converter
GLITCH, MOST = 5.0, 99.0  # times the usual magnitude that no motion explains; the percentile that is usual

OWN_NAME, WORDS, UNIT_FITS, UNIT_ALONE, RAW_MORE = 6.0, 4.0, 3.0, 1.0, 0.5  # points of a score


@dataclass(frozen=True)
class Candidate:
    """A column and the signal that it may be."""

    column: Column
    signal: Signal
    why: str
    score: float
    joint: str  # that its name says; "" where it says none
    group: str  # number in its name, "" for none


def hose_of(stem: str, stems: Iterable[str]) -> str:
    """Return the hose of a numbered name: "p1" beside "p2", or alone, is of hose A, and so is "p0" beside "p1"."""
    numbers = list(re.finditer(r"\d+", stem))
    if not numbers or not CHANNELS.isdisjoint(words_of(stem)):
        return ""
    head, number, tail = stem[: numbers[-1].start()], numbers[-1][0], stem[numbers[-1].end() :]
    pattern = re.compile(rf"{re.escape(head)}(\d+){re.escape(tail)}")
    kin = {match[1] for other in stems if (match := pattern.fullmatch(other))}
    pair = ("0", "1") if kin == {"0", "1"} else ("1", "2")
    return "ab"[pair.index(number)] if number in pair and kin <= set(pair) else ""


def find_candidate(column: Column, joints: list[str], hose: str = "") -> Candidate | str:
    """Return the signal that a column may be, or why it is left out.

    Args:
        column: to look at.
        joints: of the machine; empty where it is not known.
        hose: "a" or "b" that the number in its name may stand for.

    Returns:
        The signal with what speaks for it; or a reason in words.
    """
    header = column.header
    if not np.isfinite(column.values).any():
        return "empty"
    words = words_of(header.stem)
    joint = next((name for name in joints if set(words_of(name)) <= set(words)), "")
    own, _, own_joint = header.stem.partition(".")
    own = SENSED.get(own, own)
    if not joint and not joints and own in SIGNALS:
        joint = own_joint
    words = [word for word in words if word not in words_of(joint)]
    kind = kind_of_unit(header.unit) if header.unit else None
    meant, group, counted = _roles(words, kind, bool(joint), header.stem, hose)
    if why := _no_signal(column, set(words), meant):
        return why
    measured = own in SIGNALS and (not header.unit or kind in {None, SIGNALS[own].kind})
    name = own if measured else _signal_of(meant, kind)
    if name is None:
        if kind is not None and kind.unit in BY_UNIT:
            signal = SIGNALS[BY_UNIT[kind.unit]]
            why = f"{signal.name} by its unit alone: check it"
            return _checked(Candidate(column, signal, why, UNIT_ALONE, joint, group))
        low, high = np.nanmin(column.values), np.nanmax(column.values)
        return f"its name says nothing that is known here; goes from {low:.4g} to {high:.4g}"
    score = (OWN_NAME if SENSED.get(own.lower(), own.lower()) == name else WORDS) + UNIT_FITS * bool(header.unit)
    score += RAW_MORE * (bool(RAW & set(words)) - bool(FILTERED & set(words)))  # a fit models the sensor itself
    return _checked(Candidate(column, SIGNALS[name], f"{name} by its name{counted}", score, joint, group))


def _no_signal(column: Column, words: set[str], meant: set[str]) -> str:
    """Return why a column is none of the signals, by its name; empty where it may be one."""
    if "rate" in meant:
        return "a rate, which follows from the rest"
    if STATISTICS & words:
        return "a statistic of samples, not a sample"
    if "current" in words and not meant & QUANTITIES:
        return 'a current, which no signal is; a mapping may take it with a unit such as "0.5 V" for one of it'
    if {"ambient", "pressure"} <= meant:
        value = f"{float(np.nanmedian(column.values)):.4g} {column.header.unit or 'hPa'}"
        return f'the ambient pressure: if gauges count from it, say ambient = "{value}" at the top of the mapping'
    return ""


def find_unused(table: Table, used: Iterable[str | None]) -> list[str]:
    """Return the columns that may be signals, beside those that are used.

    Args:
        table: of the log.
        used: names of columns.
    """
    left = [name for name in table.columns if name not in set(used)]
    return [name for name in left if isinstance(find_candidate(table.columns[name], []), Candidate)]


def _roles(words: list[str], kind: u.Quantity | None, jointed: bool, stem: str, hose: str) -> tuple[set[str], str, str]:
    """Return the roles of a name's words, the number that may be a joint's, and a word on a number taken for a hose."""
    numbers = [word for before, word in zip(["", *words], words, strict=False) if _numbers_joint(before, word)]
    group = numbers[-1] if numbers and not stem.isdigit() else ""
    meant, counted = meanings(words), ""
    pressed = "pressure" in meant or kind == u.PRESSURE
    if hose and group and pressed and not meant & {"a", "b", "difference", "supply"}:
        meant, counted, group = meant | {hose}, f", whose {group} is taken for hose {hose.upper()}: check it", ""
    if "position" in meant and (jointed or "joint" in words or kind == u.ANGLE):
        meant = meant | {"angle"}
    return meant, group, counted


def _numbers_joint(before: str, word: str) -> bool:
    """Return whether a word is a number that may be a joint's or a hose's: none behind one of a recorder's channels."""
    return word.isdigit() and before not in CHANNELS


def _signal_of(meant: set[str], kind: u.Quantity | None) -> str | None:
    """Return the signal that the roles of words and a unit's kind make."""
    told = {u.PRESSURE: "pressure", u.ANGLE: "angle", u.VOLTAGE: "voltage", u.TORQUE: "torque", FORCE: "force"}
    kinds = {
        "pressure",
        "angle",
        "voltage",
        "torque",
        "force",
        "supply",
        "difference",
        "brake",
        "payload",
        "temperature",
        "position",
    }
    if kind in told and meant & {"a", "b", "asked"} and not meant & kinds and (kind != u.TORQUE):
        meant = meant | {told[kind]}
    if meant == {"clock"} and kind is not None and kind != u.TIME:
        return None  # the t of "T [K]"
    return signal_of(meant)


def _checked(candidate: Candidate) -> Candidate | str:
    """Return a candidate whose stated unit is one that its values can have; else why it is left out."""
    header, signal, kind = candidate.column.header, candidate.signal, candidate.signal.kind
    fits = (kind is not None and measures(header.unit, kind)) or (kind is None and header.unit in {"%", "1"})
    if header.unit and not fits:
        return (
            f"{signal.name} by its name, but {header.unit!r} is not a unit of it; if it is one before its scale, write "
            f'a mapping with a unit such as "0.5 {signal.unit}" for one {header.unit}, and offset'
        )
    if header.unknown:
        return (
            f"{candidate.why}, but its unit {header.unknown!r} is not known: write a mapping with a unit such as "
            f'"{signal.unit}", or "0.5 {signal.unit}" for one of it'
        )
    if COUNTS & set(words_of(header.stem)) and not header.unit:
        return (
            f"{candidate.why}, but in counts: write a mapping with a unit such as "
            f'"0.5 {signal.unit}" for one of them, and offset'
        )
    return _possible(candidate)


def _possible(candidate: Candidate) -> Candidate | str:
    """Return a candidate whose values its signal can have, with a word on single ones that it can't; else why not."""
    header, signal, kind = candidate.column.header, candidate.signal, candidate.signal.kind
    if kind is None:
        return candidate
    low, high = POSSIBLE.get(kind, (0.0, np.inf))
    unit, _ = unit_of(candidate.column, signal)
    if not unit:
        least = usual_most(candidate.column.values)
        return f"{candidate.why}, but up to {least:.3g}, which may be rad or deg: write a mapping with its unit"
    factor, shift = conversion(unit, signal)
    sizes = np.abs(candidate.column.values * factor + shift)
    most = usual_most(sizes)
    if not header.unit and most > high:
        return (
            f"{candidate.why}, but up to {usual_most(candidate.column.values):.3g}, which is too much for any usual "
            "unit of it: write a mapping with its unit"
        )
    if most > high or (header.unit and 0.0 < most < low and (signal.absolute or kind == u.TEMPERATURE)):
        return (
            f"{candidate.why}, but up to {most:.3g} {signal.unit} by its stated unit {header.unit!r}, which can't be: "
            "write a mapping with the right unit"
        )
    beyond = int(np.sum(sizes > high))
    if not beyond:
        return candidate
    told = f"{beyond} sample{'s' if beyond > 1 else ''} beyond what can be: `layflat log check` looks at them"
    return replace(candidate, why=f"{candidate.why}; {told}")


def usual_most(values: Array) -> float:
    """Return the greatest finite magnitude of a column, without single samples that are far beyond the rest."""
    sizes = np.abs(values[np.isfinite(values)])
    if not sizes.size:
        return 0.0
    usual, most = float(np.percentile(sizes, MOST)), float(sizes.max())
    return usual if usual > 0.0 and most > GLITCH * usual else most


def unit_of(column: Column, signal: Signal) -> tuple[str, str]:
    """Return the unit of a column, from its header or by its values, and why."""
    if column.header.unit:
        return column.header.unit, "unit as in the header"
    known = column.values[np.isfinite(column.values)]
    most = usual_most(known)
    if signal.kind is None:
        return ("%" if most > 1.5 else "1"), f"unit by values up to {most:.3g}: check it"
    if signal.kind not in RANGES:
        return signal.unit, "no unit is said: check it"
    unit = next(unit for limit, unit in RANGES[signal.kind] if most <= limit)
    whole = known.size > 0 and most > LEAST_COUNT and bool(np.all(known % 1.0 == 0.0))
    counted = ", which are whole numbers and may be counts" if whole else ""
    return unit, f"unit by values up to {most:.3g}{counted}: check it"
