"""Evidence that a column is a signal: its name, its unit, and its values."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.identify.logs.mapping import SENSED_SIGNALS
from layflat.identify.logs.table import LogColumn, LogTable, split_words
from layflat.identify.logs.vocabulary import (
    FILTER_WORDS,
    FORCE,
    RAW_WORDS,
    SIGNALS,
    STATISTIC_WORDS,
    LogSignal,
    is_unit_of,
    kind_of_unit,
    signal_for_roles,
    unit_conversion,
    word_roles,
)

SIGNAL_BY_UNIT = {"rad": "angle", "Pa": "pressure", "V": "voltage", "N*m": "torque", "N": "force", "K": "temperature"}
"""Signal that a unit alone suggests, by its SI unit."""

POSSIBLE_MAGNITUDES: dict[u.Quantity, tuple[float, float]] = {
    u.PRESSURE: (100.0, 1e8), u.ANGLE: (0.0, 4.0 * np.pi), u.VOLTAGE: (0.0, 1e3), u.TORQUE: (0.0, 1e5),
    FORCE: (0.0, 1e7), u.TEMPERATURE: (60.0, 2e3), u.LENGTH: (0.0, 100.0), u.MASS: (0.0, 1e4),
}  # fmt: skip
"""Lower and upper limit of the greatest magnitude of a signal, SI: outside them a stated unit is wrong."""

UNIT_LIMITS: dict[u.Quantity, tuple[tuple[float, str], ...]] = {
    u.ANGLE: ((3.5, "rad"), (7.0, ""), (np.inf, "deg")),  # neither a few degrees nor a whole turn is usual
    u.PRESSURE: ((20.0, "bar"), (160.0, "psi"), (5e3, "kPa"), (np.inf, "Pa")),
    u.VOLTAGE: ((30.0, "V"), (np.inf, "mV")),
    u.TEMPERATURE: ((150.0, "degC"), (np.inf, "K")),
    u.LENGTH: ((2.0, "m"), (np.inf, "mm")),
}
"""Greatest value that is likely in each unit, in rising order; "" where the unit is ambiguous."""

_CHANNELS = "ch chan channel kanal canal ai ain ao aout analog adc dac dev input port slot module"
CHANNELS = frozenset(_CHANNELS.split())
"""Words before the number of a recorder's channel, which is not the number of a joint or a hose."""

QUANTITIES = frozenset(["pressure", "angle", "torque", "force", "temperature", "position", "brake"])
"""Roles beside which the word "current" means the present value, not amperes."""

COUNT_WORDS = frozenset(["counts", "dac", "adc", "pwm", "lsb", "digit", "digits", "bits", "inc", "incr", "increments"])
"""Words for raw counts of a converter, which are no quantity without their scale."""

MIN_CONVERTER_COUNT = 200.0  # from which integers may be counts of a converter
MIN_GLITCH_RATIO = 5.0  # greatest over usual magnitude that no motion explains
USUAL_PERCENTILE = 99.0  # of the magnitudes: the usual one

OWN_NAME_POINTS, WORD_POINTS, UNIT_POINTS, UNIT_ALONE_POINTS, RAW_POINTS = 6.0, 4.0, 3.0, 1.0, 0.5  # points of a score


@dataclass(frozen=True)
class SignalCandidate:
    """Signal that a column may be, with its score."""

    column: LogColumn
    signal: LogSignal
    why: str  # evidence, for people
    score: float  # points
    joint: str  # in its name, "" for none
    group: str  # number in its name, "" for none


def hose_by_number(stem: str, stems: Iterable[str]) -> str:
    """Return the hose of a numbered name, "a" or "b", else "".

    "p1" beside "p2", or alone, is of hose A; so is "p0" beside "p1".
    """
    numbers = list(re.finditer(r"\d+", stem))
    if not numbers or not CHANNELS.isdisjoint(split_words(stem)):
        return ""
    head, number, tail = stem[: numbers[-1].start()], numbers[-1][0], stem[numbers[-1].end() :]
    pattern = re.compile(rf"{re.escape(head)}(\d+){re.escape(tail)}")
    kin = {match[1] for other in stems if (match := pattern.fullmatch(other))}
    pair = ("0", "1") if kin == {"0", "1"} else ("1", "2")
    return "ab"[pair.index(number)] if number in pair and kin <= set(pair) else ""


def find_candidate(column: LogColumn, joints: list[str], hose: str = "") -> SignalCandidate | str:
    """Return the signal that a column may be, or why it is left out.

    Args:
        column: column of the log.
        joints: joints of the machine; empty where it is not known.
        hose: "a" or "b" if the number in its name may stand for it.

    Returns:
        The signal with its score; or the reason why the column is left out.
    """
    header = column.header
    if not np.isfinite(column.values).any():
        return "empty"
    words = split_words(header.stem)
    joint = next((name for name in joints if set(split_words(name)) <= set(words)), "")
    stem, _, stem_joint = header.stem.partition(".")
    stem = SENSED_SIGNALS.get(stem, stem)
    if not joint and not joints and stem in SIGNALS:
        joint = stem_joint
    words = [word for word in words if word not in split_words(joint)]
    kind = kind_of_unit(header.unit) if header.unit else None
    roles, group, counted = _name_roles(words, kind, bool(joint), header.stem, hose)
    if why := _exclusion_reason(column, set(words), roles):
        return why
    named = stem in SIGNALS and (not header.unit or kind in {None, SIGNALS[stem].kind})
    name = stem if named else _signal_by_roles(roles, kind)
    if name is None:
        if kind is not None and kind.unit in SIGNAL_BY_UNIT:
            signal = SIGNALS[SIGNAL_BY_UNIT[kind.unit]]
            why = f"{signal.name} by its unit alone: check it"
            return _check_stated_unit(SignalCandidate(column, signal, why, UNIT_ALONE_POINTS, joint, group))
        low, high = np.nanmin(column.values), np.nanmax(column.values)
        return f"its name says nothing that is known here; goes from {low:.4g} to {high:.4g}"
    own_name = SENSED_SIGNALS.get(stem.lower(), stem.lower()) == name
    score = (OWN_NAME_POINTS if own_name else WORD_POINTS) + UNIT_POINTS * bool(header.unit)
    raw, filtered = bool(RAW_WORDS & set(words)), bool(FILTER_WORDS & set(words))
    score += RAW_POINTS * (raw - filtered)  # fits model the sensor, and need no filter
    return _check_stated_unit(
        SignalCandidate(column, SIGNALS[name], f"{name} by its name{counted}", score, joint, group)
    )


def _exclusion_reason(column: LogColumn, words: set[str], roles: set[str]) -> str:
    """Return why the name of a column excludes all signals; "" where it may be one."""
    if "rate" in roles:
        return "a rate, which follows from the rest"
    if STATISTIC_WORDS & words:
        return "a statistic of samples, not a sample"
    if "current" in words and not roles & QUANTITIES:
        return 'a current, which no signal is; a mapping may take it with a unit such as "0.5 V" for one of it'
    if {"ambient", "pressure"} <= roles:
        value = f"{float(np.nanmedian(column.values)):.4g} {column.header.unit or 'hPa'}"
        return f'the ambient pressure: if gauges count from it, say ambient = "{value}" at the top of the mapping'
    return ""


def find_unused(table: LogTable, used: Iterable[str | None]) -> list[str]:
    """Return the names of unused columns that may be signals.

    Args:
        table: table of the log.
        used: names of the columns that are used.
    """
    unused = [name for name in table.columns if name not in set(used)]
    return [name for name in unused if isinstance(find_candidate(table.columns[name], []), SignalCandidate)]


def _name_roles(
    words: list[str], kind: u.Quantity | None, jointed: bool, stem: str, hose: str
) -> tuple[set[str], str, str]:
    """Return the roles of a name's words, the number that may be a joint's, and a note on a number read as a hose.

    Both texts may be empty.

    Args:
        words: words of the name, without those of its joint.
        kind: quantity of the unit, if known.
        jointed: whether the name has a joint's.
        stem: the name without its unit.
        hose: hose that a number in the name may stand for, "a" or "b", else "".
    """
    numbers = [word for before, word in zip(["", *words], words, strict=False) if _is_joint_number(before, word)]
    group = numbers[-1] if numbers and not stem.isdigit() else ""
    roles, note = word_roles(words), ""
    pressed = "pressure" in roles or kind == u.PRESSURE
    if hose and group and pressed and not roles & {"a", "b", "difference", "supply"}:
        roles, note, group = roles | {hose}, f", whose {group} is taken for hose {hose.upper()}: check it", ""
    if "position" in roles and (jointed or "joint" in words or kind == u.ANGLE):
        roles = roles | {"angle"}
    return roles, group, note


def _is_joint_number(before: str, word: str) -> bool:
    """Return whether a word is a number that may be a joint's or a hose's, not a recorder's channel."""
    return word.isdigit() and before not in CHANNELS


def _signal_by_roles(roles: set[str], kind: u.Quantity | None) -> str | None:
    """Return the signal by the roles of words and the kind of a unit; None where there is none."""
    role_by_kind = {u.PRESSURE: "pressure", u.ANGLE: "angle", u.VOLTAGE: "voltage", u.TORQUE: "torque", FORCE: "force"}
    kinds = QUANTITIES | {"voltage", "supply", "difference", "payload"}
    if kind in role_by_kind and roles & {"a", "b", "asked"} and not roles & kinds and (kind != u.TORQUE):
        roles = roles | {role_by_kind[kind]}
    if roles == {"clock"} and kind is not None and kind != u.TIME:
        return None  # the t of "T [K]"
    return signal_for_roles(roles)


def _check_stated_unit(candidate: SignalCandidate) -> SignalCandidate | str:
    """Return the candidate if its unit fits the signal and its values are possible; else why it is left out."""
    header, signal, kind = candidate.column.header, candidate.signal, candidate.signal.kind
    fits = (kind is not None and is_unit_of(header.unit, kind)) or (kind is None and header.unit in {"%", "1"})
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
    if COUNT_WORDS & set(split_words(header.stem)) and not header.unit:
        return (
            f"{candidate.why}, but in counts: write a mapping with a unit such as "
            f'"0.5 {signal.unit}" for one of them, and offset'
        )
    return _check_magnitude(candidate)


def _check_magnitude(candidate: SignalCandidate) -> SignalCandidate | str:
    """Return the candidate, with a note on single values that can't be; or why it is refused.

    It is refused if its usual values can't be, or if they leave open which unit they have.
    """
    header, signal, kind = candidate.column.header, candidate.signal, candidate.signal.kind
    if kind is None:
        return candidate
    low, high = POSSIBLE_MAGNITUDES.get(kind, (0.0, np.inf))
    unit, _ = choose_unit(candidate.column, signal)
    if not unit:
        magnitude = usual_magnitude(candidate.column.values)
        return f"{candidate.why}, but up to {magnitude:.3g}, which may be rad or deg: write a mapping with its unit"
    factor, shift = unit_conversion(unit, signal)
    sizes = np.abs(candidate.column.values * factor + shift)
    magnitude = usual_magnitude(sizes)
    if not header.unit and magnitude > high:
        return (
            f"{candidate.why}, but up to {usual_magnitude(candidate.column.values):.3g}, which is too much for any "
            "usual unit of it: write a mapping with its unit"
        )
    if magnitude > high or (header.unit and 0.0 < magnitude < low and (signal.absolute or kind == u.TEMPERATURE)):
        return (
            f"{candidate.why}, but up to {magnitude:.3g} {signal.unit} by its stated unit {header.unit!r}, which can't "
            "be: write a mapping with the right unit"
        )
    beyond = int(np.sum(sizes > high))
    if not beyond:
        return candidate
    note = f"{beyond} sample{'s' if beyond > 1 else ''} beyond what can be: `layflat log check` looks at them"
    return replace(candidate, why=f"{candidate.why}; {note}")


def usual_magnitude(values: Array) -> float:
    """Return the greatest finite magnitude of a column, or the 99th percentile where glitches are over 5 times that.

    It is 0 without a finite value.
    """
    sizes = np.abs(values[np.isfinite(values)])
    if not sizes.size:
        return 0.0
    typical, greatest = float(np.percentile(sizes, USUAL_PERCENTILE)), float(sizes.max())
    return typical if typical > 0.0 and greatest > MIN_GLITCH_RATIO * typical else greatest


def choose_unit(column: LogColumn, signal: LogSignal) -> tuple[str, str]:
    """Return the unit of a column, from its header or by its values ("" if these are ambiguous), and the reason."""
    if column.header.unit:
        return column.header.unit, "unit as in the header"
    finite = column.values[np.isfinite(column.values)]
    magnitude = usual_magnitude(finite)
    if signal.kind is None:
        return ("%" if magnitude > 1.5 else "1"), f"unit by values up to {magnitude:.3g}: check it"
    if signal.kind not in UNIT_LIMITS:
        return signal.unit, "no unit is said: check it"
    unit = next(unit for limit, unit in UNIT_LIMITS[signal.kind] if magnitude <= limit)
    whole = finite.size > 0 and magnitude > MIN_CONVERTER_COUNT and bool(np.all(finite % 1.0 == 0.0))
    note = ", which are whole numbers and may be counts" if whole else ""
    return unit, f"unit by values up to {magnitude:.3g}{note}: check it"
