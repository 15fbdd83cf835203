"""A first mapping of a log that nobody has described yet: from names, units in headers, and ranges of values.

It is a proposal with reasons, for a person to look through; nothing applies it by itself.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.identify.logs.headers import meanings, signal_of, words_of
from layflat.identify.logs.mapping import Mapping, mapping_of
from layflat.identify.logs.own import own_mapping
from layflat.identify.logs.signals import AMBIENT, SIGNALS, Signal, channel_name, conversion
from layflat.identify.logs.table import Column, Table, read_table

BY_UNIT = {"rad": "angle", "Pa": "pressure", "V": "voltage", "N*m": "torque", "N": "force", "K": "temperature"}
"""What a unit alone tells, by its SI unit."""

RANGES: dict[u.Quantity, tuple[tuple[float, str], ...]] = {
    u.ANGLE: ((7.0, "rad"), (np.inf, "deg")),
    u.PRESSURE: ((20.0, "bar"), (160.0, "psi"), (5e3, "kPa"), (np.inf, "Pa")),
    u.VOLTAGE: ((30.0, "V"), (np.inf, "mV")),
    u.TEMPERATURE: ((150.0, "degC"), (np.inf, "K")),
    u.LENGTH: ((2.0, "m"), (np.inf, "mm")),
}
"""Units by the greatest value that would be likely in them."""

STEPS = ((0.7, "s"), (700.0, "ms"), (7e5, "us"), (np.inf, "ns"))  # the same of time, by the greatest step


@dataclass(frozen=True)
class Guess:
    """A proposal."""

    mapping: Mapping
    notes: dict[str, str]  # of each column, what it is taken for or why it is left out; "" is the clock's


@dataclass(frozen=True)
class _Candidate:
    column: Column
    signal: Signal
    why: str
    joint: str
    group: str


def guess_mapping(table: Table | str | Path, joints: Sequence[str] | None = None) -> Guess:
    """Propose what the columns of a log, or of its file, are; raise InputError if none looks like anything.

    Columns go to the machine's joints by name; numbered ones, q0, q1 ..., by their order, and where there are more
    numbers than joints, to those that move most.
    """
    table = table if isinstance(table, Table) else read_table(table)
    own = own_mapping(table)
    if own is not None:
        return Guess(own, {entry.columns[0]: "one of layflat's own names" for entry in own.column})
    clock, why = _clock(table)
    known = list(joints or ())
    found = {name: _candidate(one, known) for name, one in table.columns.items() if name != clock["column"]}
    notes = {"": why} | {name: why for name, why in found.items() if isinstance(why, str)}
    entries = _entries([one for one in found.values() if isinstance(one, _Candidate)], known, notes)
    if not entries:
        names = ", ".join(list(table.columns)[:8])
        right = f"write a mapping file by hand that says which of {names} is which signal"
        raise InputError("no column looks like a signal", where=str(table.path), right=right)
    return Guess(mapping_of({"time": clock, "column": entries}, str(table.path)), notes)


def _clock(table: Table) -> tuple[dict[str, str], str]:
    """The column that is the clock with its unit, and why."""
    if table.clock is not None:
        return {"column": table.clock.name, "unit": table.clock.unit or "s"}, "every sample has a time of its own"
    rising = {name: column for name, column in table.columns.items() if _rises(column.values)}
    by_name = [name for name, column in rising.items() if "clock" in meanings(words_of(column.header.stem))]
    by_unit = [name for name, column in rising.items() if _is_unit_of(column.header.unit, u.TIME)]
    chosen = next(iter([*by_name, *by_unit, *rising]), None)
    if chosen is None:
        raise InputError("no column rises as a clock does", where=str(table.path), right="write a mapping file by hand")
    why = "by its name" if chosen in by_name else "by its unit" if chosen in by_unit else "as its values keep rising"
    if _is_unit_of(rising[chosen].header.unit, u.TIME):
        return {"column": chosen, "unit": rising[chosen].header.unit}, f"the clock {why}; unit as in the header"
    step = float(np.median(np.diff(rising[chosen].values)))
    unit = next(unit for most, unit in STEPS if step < most)
    return {"column": chosen, "unit": unit}, f"the clock {why}; unit by its steps of {step:.4g}: check it"


def _rises(values: Array) -> bool:
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size and np.mean(steps >= 0.0) > 0.99 and np.median(steps) > 0.0)


def _is_unit_of(unit: str, kind: u.Quantity) -> bool:
    try:
        kind.convert(f"1 {unit}")
    except ValueError:
        return False
    return bool(unit)


def _candidate(column: Column, joints: list[str]) -> _Candidate | str:
    """What a column may be, or why it is left out."""
    if not np.isfinite(column.values).any():
        return "empty"
    words = words_of(column.header.stem)
    joint = next((name for name in joints if set(words_of(name)) <= set(words)), "")
    words = [word for word in words if word not in words_of(joint)]
    numbers = [word for word in words if word.isdigit()]
    group = numbers[-1] if numbers else ""
    meant = meanings(words)
    if "rate" in meant:
        return "a rate, which follows from the rest"
    if group in {"1", "2"} and meant & {"pressure"} and not meant & {"a", "b", "difference", "supply"}:
        meant, group = meant | {"a" if group == "1" else "b"}, ""
    if "position" in meant and (joint or "joint" in words or _is_unit_of(column.header.unit, u.ANGLE)):
        meant = meant | {"angle"}
    name, unit = signal_of(meant), column.header.unit
    kind = next((s.kind for s in SIGNALS.values() if s.kind is not None and _is_unit_of(unit, s.kind)), None)
    if name is not None and (kind is None or SIGNALS[name].kind == kind):
        return _Candidate(column, SIGNALS[name], f"{name} by its name", joint, group)
    if kind is not None and kind.unit in BY_UNIT:
        name = BY_UNIT[kind.unit]
        return _Candidate(column, SIGNALS[name], f"{name} by its unit alone: check it", joint, group)
    low, high = np.nanmin(column.values), np.nanmax(column.values)
    return f"its name says nothing that is known here; goes from {low:.4g} to {high:.4g}"


def _entries(candidates: list[_Candidate], joints: list[str], notes: dict[str, str]) -> list[dict[str, Any]]:
    """Entries of a mapping, one a channel; what is left out is noted."""
    named = _joints_of_groups(candidates, joints)
    entries, unsure = list[dict[str, Any]](), list[dict[str, Any]]()
    taken: dict[str, str] = {}
    for found in candidates:
        header, signal = found.column.header, found.signal
        joint = (found.joint or named.get(found.group)) if signal.by_joint else None
        if signal.by_joint and joint is None and named:
            notes[header.name] = f"{found.why}, but of none of the joints"
            continue
        channel = channel_name(signal.name, joint)
        if channel in taken:
            notes[header.name] = f"{found.why}, but {taken[channel]} is {channel} already"
            continue
        taken[channel] = header.name
        unit, why = _unit(found.column, signal)
        entry: dict[str, Any] = {"from": header.name, "signal": signal.name, "unit": unit}
        entry |= {"joint": joint} if joint else {}
        entries.append(entry)
        notes[header.name] = f"{found.why}; {why}"
        if signal.absolute and header.gauge is not None:
            entry["gauge"] = header.gauge
            notes[header.name] += f"; {'gauge' if header.gauge else 'absolute'} as in the header"
        elif signal.absolute:
            # Only a gauge pressure falls below ambient.
            entry["gauge"] = float(np.nanmin(found.column.values)) * conversion(unit, signal)[0] < 0.8 * AMBIENT
            unsure.append(entry)
    any_sunk = any(entry["gauge"] for entry in unsure)
    for entry in unsure:
        by = "by how far it falls" if entry["gauge"] == any_sunk else "as others are"
        entry["gauge"] = any_sunk
        notes[entry["from"]] += f"; {'gauge' if any_sunk else 'absolute'} {by}: check it"
    return entries


def _joints_of_groups(candidates: list[_Candidate], joints: list[str]) -> dict[str, str]:
    """Joint by the number in the names of its columns, "" for none; empty where the log has no joints."""
    mine = [found for found in candidates if found.signal.by_joint and not found.joint]
    numbers = sorted({found.group for found in mine if found.group}, key=int)
    if len(joints) == 1 and not numbers:
        return {"": joints[0]}
    if not joints:
        return {number: f"joint{number}" for number in numbers}
    if len(numbers) > len(joints):
        angles = [found for found in mine if found.signal.name in {"angle", "demand"}]
        moved = {
            n: max((float(np.nanstd(f.column.values)) for f in angles if f.group == n), default=0.0) for n in numbers
        }
        numbers = sorted(sorted(numbers, key=lambda number: -moved[number])[: len(joints)], key=int)
    named = dict(zip(numbers, joints, strict=False))
    return named if len(joints) > 1 or not named else named | {"": joints[0]}


def _unit(column: Column, signal: Signal) -> tuple[str, str]:
    """A unit, and why."""
    with suppress(ValueError):
        if column.header.unit and conversion(column.header.unit, signal):
            return column.header.unit, "unit as in the header"
    most = float(np.nanmax(np.abs(column.values)))
    if signal.kind is None:
        return ("%" if most > 1.5 else "1"), f"unit by values up to {most:.3g}: check it"
    if signal.kind not in RANGES:
        return signal.unit, "no unit is said: check it"
    unit = next(unit for limit, unit in RANGES[signal.kind] if most <= limit)
    return unit, f"unit by values up to {most:.3g}: check it"
