"""A first mapping of a log that nobody has described yet: from names, units in headers, and ranges of values.

It is a proposal with reasons, for a person to look through; nothing applies it by itself.
"""

from collections import Counter
from collections.abc import Mapping as Map
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from layflat.description import units as u
from layflat.errors import InputError
from layflat.identify.logs.clocks import ClockChoice, choose_clock, describe_stamps, rises, usual_step
from layflat.identify.logs.evidence import Candidate, find_candidate, find_unused, hose_of, unit_of
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.mapping import Mapping, mapping_of, own_mapping
from layflat.identify.logs.table import Column, Table
from layflat.identify.logs.vocabulary import AMBIENT, SIGNALS, channel_name, conversion

USUAL_STEPS = (1e-6, 0.7)  # s between two samples of a log of a motion
CLEAR = 0.4  # points by which one of two columns for one signal must be ahead


@dataclass(frozen=True)
class Guess:
    """A proposal."""

    mapping: Mapping
    notes: dict[str, str]  # of each column, what it is taken for or why it is left out; "" is the clock's
    left: dict[str, str] = field(default_factory=dict)  # columns that are left out, and why
    scores: dict[str, list[tuple[str, float, str]]] = field(default_factory=dict)  # signal, points and reason by column


def guess_mapping(
    table: Table | str | Path, joints: Sequence[str] | None = None, period: float | str | None = None
) -> Guess:
    """Propose what the columns of a log, or of its file, are.

    Columns go to the machine's joints by name; numbered ones, q0, q1 ..., by their order, and where there are more
    numbers than joints, to those that move most. Where two columns may be one signal and neither is ahead, both are
    left out.

    Args:
        table: of the log, or its file.
        joints: of the machine.
        period: between two samples of a log without a clock, such as "5 ms"; its columns are no clock then.

    Raises:
        InputError: there is no clock, or no column looks like a signal.
    """
    table = table if isinstance(table, Table) else read_table(table)
    own = None
    with suppress(InputError):  # a stated unit that an own name can't have
        own = own_mapping(table) if period is None else None
    if own is not None and _is_whole(own, table):
        return Guess(own, _own_notes(own, table), dict(table.words))
    known = list(joints or ())
    clock = (
        choose_clock(table) if period is None else ClockChoice("", "s", "samples are evenly spaced, as was said", {})
    )
    stems = [one.header.stem for one in table.columns.values()]
    found = {
        name: find_candidate(one, known, hose_of(one.header.stem, stems))
        for name, one in table.columns.items()
        if name != clock.column
    }
    notes = {"": clock.why} | {name: why for name, why in found.items() if isinstance(why, str)} | dict(table.words)
    for name in clock.scores:
        if name != clock.column and isinstance(found.get(name), str) and clock.scores[name][0] >= 1.0:
            notes[name] = f"a clock {clock.scores[name][1]}, but {clock.column} is taken"
    candidates = [one for one in found.values() if isinstance(one, Candidate)]
    scores = {name: [("time", *score)] for name, score in clock.scores.items()}
    for one in candidates:
        scores.setdefault(one.column.header.name, []).append((one.signal.name, one.score, one.why))
    entries = _entries(candidates, known, notes)
    if not entries:
        reasons = "; ".join(f"{name}: {notes[name]}" for name in list(table.columns)[:8] if notes.get(name))
        bare = all(name.isdigit() for name in table.columns)
        header = "give it a header, such as time_s,angle_deg,pA_kPa_gauge,valve_V, or " if bare else ""
        several = not known and any("may all be" in why for why in notes.values())
        header += "say which joints the names may have (--machine), or " if several else ""
        right = f"{header}write a mapping file by hand that says which column is which signal ({reasons})"
        what = "no column looks like a signal" + (": the table has no header" if bare else "")
        raise InputError(what, where=str(table.path), right=right)
    for name in notes:
        if name in table.columns and table.columns[name].notes and name != clock.column:
            notes[name] += "".join(f"; {note}" for note in table.columns[name].notes)
    time = {"column": clock.column, "unit": clock.unit}
    if period is not None or clock.period is not None:
        step = clock.period if period is None else u.quantity(period, u.TIME, "period")
        time = {"period": f"{step!r} s"}
    mapping = mapping_of({"time": time, "column": entries}, str(table.path))
    mapped = {column for entry in mapping.column for column in entry.columns} | {"", clock.column}
    return Guess(mapping, notes, {name: why for name, why in notes.items() if name not in mapped}, scores)


def _own_notes(own: Mapping, table: Table) -> dict[str, str]:
    """Return what there is to say of columns with layflat's own names."""
    notes = {}
    if own.time is not None and own.time.column is not None:
        clock = table.columns[own.time.column]
        unit = "unit as in the header" if clock.header.unit else "in s, as nothing else is said"
        told, _ = describe_stamps(clock.values, own.time.unit, [], f"{table.path}: {own.time.column}")
        notes[""] = "; ".join(("the clock by its name", unit, *clock.notes)) + told
    for entry in own.column:
        column = table.columns[entry.columns[0]]
        unit = "unit as in the header" if column.header.unit else f"in {entry.unit}, as nothing else is said"
        notes[entry.columns[0]] = "; ".join(("one of layflat's own names", unit, *column.notes))
    return notes


def _is_whole(own: Mapping, table: Table) -> bool:
    """Tell whether a log has layflat's own names alone, with values that they can have in SI."""
    used = {column for entry in own.column for column in entry.columns} | {own.time.column if own.time else None}
    simulated = any(name.startswith("measured_angle") for name in used if name)
    beside = [name for name in table.columns if name not in used] if table.clock is None else find_unused(table, used)
    if beside and not simulated:
        return False
    stamps = next((column.stamps for column in table.columns.values() if column.stamps is not None), None)
    if table.clock is not None and not table.clock.unit and stamps is not None:
        return USUAL_STEPS[0] < usual_step(stamps) < USUAL_STEPS[1]
    if own.time is not None and own.time.column is not None:
        clock = table.columns[own.time.column]
        step = usual_step(clock.values)
        shared = np.any(np.diff(clock.values) == 0.0)
        stated = clock.header.unit or USUAL_STEPS[0] < step < USUAL_STEPS[1]
        if not rises(clock.values) or shared or not stated:
            return False
    for entry in own.column:
        column, signal = table.columns[entry.columns[0]], SIGNALS[entry.signal]
        most = float(np.nanmax(np.abs(column.values), initial=0.0)) if np.isfinite(column.values).any() else 0.0
        stated = bool(column.header.unit)
        if not stated and ((signal.kind == u.ANGLE and most > 4.0 * np.pi) or (signal.absolute and 0.0 < most < 1e3)):
            return False
    return True


def _entries(candidates: list[Candidate], joints: list[str], notes: dict[str, str]) -> list[dict[str, Any]]:
    """Return entries of a mapping, one a channel; what is left out is noted."""
    named = _joints_of_groups(candidates, joints)
    channels: dict[str, list[tuple[Candidate, str | None]]] = {}
    hosed = any(one.signal.name in {"pressure_a", "pressure_b"} for one in candidates)
    for one in candidates:
        joint = (one.joint or named.get(one.group)) if one.signal.by_joint else None
        if one.signal.by_joint and joint is None and named:
            notes[one.column.header.name] = f"{one.why}, but of none of the joints"
            continue
        channels.setdefault(channel_name(one.signal.name, joint), []).append((one, joint))
    entries: list[dict[str, Any]] = []
    for channel, rivals in channels.items():
        chosen = _chosen(channel, [one for one, _ in rivals], notes)
        if chosen is not None and chosen.signal.name == "pressure" and hosed:
            why = f"{chosen.why}, but of neither hose: name it in the mapping if it is one's"
            notes[chosen.column.header.name] = why
        elif chosen is not None:
            entries.append(_entry(chosen, rivals[0][1], notes))
    _set_gauges(entries, candidates, notes)
    return entries


def _chosen(channel: str, rivals: list[Candidate], notes: dict[str, str]) -> Candidate | None:
    """Return the column of a channel; None where several have as much to say for themselves."""
    ranked = sorted(rivals, key=lambda one: -one.score)
    first, rest = ranked[0], ranked[1:]
    name = first.column.header.name
    for one in rest:
        notes[one.column.header.name] = (
            f"{one.why}, but {name} is {channel} already, with {first.score:g} to {one.score:g} points"
        )
        if np.array_equal(one.column.values, first.column.values, equal_nan=True):
            notes[one.column.header.name] = f"{one.why}, but {name} is {channel} already, with the same values"
    equal = [
        one for one in rest if first.score - one.score < CLEAR and "same values" not in notes[one.column.header.name]
    ]
    if not equal:
        return first
    names = " and ".join(one.column.header.name for one in (first, *equal))
    for one in (first, *equal):
        notes[one.column.header.name] = (
            f"{names} may all be {channel}: name one in the mapping, or all in one list if they measure the same"
        )
    return None


def _entry(candidate: Candidate, joint: str | None, notes: dict[str, str]) -> dict[str, Any]:
    header, signal = candidate.column.header, candidate.signal
    unit, why = unit_of(candidate.column, signal)
    entry: dict[str, Any] = {"from": header.name, "signal": signal.name, "unit": unit}
    entry |= {"joint": joint} if joint else {}
    notes[header.name] = f"{candidate.why}; {why}"
    if signal.absolute and header.gauge is not None:
        entry["gauge"] = header.gauge
        notes[header.name] += f"; {'gauge' if header.gauge else 'absolute'} as in the header"
    return entry


def _set_gauges(entries: list[dict[str, Any]], candidates: list[Candidate], notes: dict[str, str]) -> None:
    """Say of pressures whose header does not say it whether they count from ambient: only those fall below it."""
    columns = {one.column.header.name: one.column for one in candidates}
    unsure = [e for e in entries if SIGNALS[e["signal"]].absolute and "gauge" not in e]
    sunk = {e["from"]: _falls(columns[e["from"]], e) for e in unsure}
    stated = {e["gauge"] for e in entries if SIGNALS[e["signal"]].absolute and "gauge" in e and e not in unsure}
    for entry in unsure:
        entry["gauge"] = any(sunk.values()) or stated == {True}
        others = sunk[entry["from"]] != entry["gauge"]
        by = (
            "as others are"
            if others
            else "by how far it falls"
            if entry["gauge"]
            else "as it never falls below ambient"
        )
        notes[entry["from"]] += f"; {'gauge' if entry['gauge'] else 'absolute'} {by}: check it"


def _falls(column: Column, entry: Map[str, Any]) -> bool:
    return float(np.nanmin(column.values)) * conversion(entry["unit"], SIGNALS[entry["signal"]])[0] < 0.8 * AMBIENT


def _are_joints(candidates: list[Candidate], numbers: list[str]) -> bool:
    """Return whether numbers in names are those of joints: some signal, or all, must be there for two of them.

    Numbers of which each has a signal of its own count the columns, and a single one tells nothing apart.
    """
    signals = Counter(one.signal.name for one in candidates if one.group)
    return len(numbers) > 1 and max(signals.values()) > 1


def _joints_of_groups(candidates: list[Candidate], joints: list[str]) -> dict[str, str]:
    """Return the joint by the number in the names of its columns, "" for none; empty where the log has no joints."""
    mine = [one for one in candidates if one.signal.by_joint and not one.joint]
    numbers = sorted({one.group for one in mine if one.group}, key=int)
    if not _are_joints(mine, numbers):
        return dict.fromkeys(("", *numbers), joints[0]) if len(joints) == 1 else {}
    if not joints:
        return {number: f"joint{number}" for number in numbers}
    if len(numbers) > len(joints):
        angles = [one for one in mine if one.signal.name in {"angle", "demand"}]
        moved = {
            n: max((float(np.nanstd(f.column.values)) for f in angles if f.group == n), default=0.0) for n in numbers
        }
        numbers = sorted(sorted(numbers, key=lambda number: -moved[number])[: len(joints)], key=int)
    named = dict(zip(numbers, joints, strict=False))
    return named if len(joints) > 1 or not named else named | {"": joints[0]}
