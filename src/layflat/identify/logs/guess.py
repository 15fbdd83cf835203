"""A first mapping of a log that nobody has described yet: from names, units in headers, and ranges of values.

It is a proposal with reasons, for a person to look through; nothing applies it by itself.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from layflat.description import units as u
from layflat.errors import InputError
from layflat.identify.logs.clocks import ClockChoice, choose_clock, describe_stamps, is_rising, median_step
from layflat.identify.logs.evidence import SignalCandidate, choose_unit, find_candidate, find_unused, hose_by_number
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.mapping import LogMapping, map_own_names, parse_mapping
from layflat.identify.logs.table import LogColumn, LogTable
from layflat.identify.logs.vocabulary import AMBIENT, SIGNALS, channel_name, unit_conversion

USUAL_STEPS = (1e-6, 0.7)  # usual range of the time between two samples, s
MIN_POINT_LEAD = 0.4  # points by which one of two columns for one signal must lead


@dataclass(frozen=True)
class MappingGuess:
    """Proposed mapping of a log, with the reasons."""

    mapping: LogMapping
    notes: dict[str, str]  # by column: its signal, or why it is left out; "" is the clock's
    ignored: dict[str, str] = field(default_factory=dict)  # reasons by column
    scores: dict[str, list[tuple[str, float, str]]] = field(default_factory=dict)
    """By column: possible signals, their points and reasons."""


def guess_mapping(
    table: LogTable | str | Path, joints: Sequence[str] | None = None, period: float | str | None = None
) -> MappingGuess:
    """Propose a mapping for the columns of a log or its file.

    Columns are assigned to the machine's joints by name; numbered ones, q0, q1 ..., by their order, and where there are
    more numbers than joints, those that move most. Where two columns may be one signal and neither leads, both are left
    out.

    Args:
        table: table of the log, or its file.
        joints: joints of the machine.
        period: period of the samples of a log without a clock, such as "5 ms"; then no column is the clock.

    Returns:
        The mapping, with the reason for each column.

    Raises:
        InputError: there is no clock, or no column looks like a signal.
    """
    table = table if isinstance(table, LogTable) else read_table(table)
    own_mapping = None
    with suppress(InputError):  # a unit in the file that the signal of this name can't have
        own_mapping = map_own_names(table) if period is None else None
    if own_mapping is not None and _covers_log(own_mapping, table):
        return MappingGuess(own_mapping, _describe_own_columns(own_mapping, table), dict(table.words))
    joint_names = list(joints or ())
    clock = (
        choose_clock(table) if period is None else ClockChoice("", "s", "samples are evenly spaced, as was said", {})
    )
    stems = [column.header.stem for column in table.columns.values()]
    candidates_by_name = {
        name: find_candidate(column, joint_names, hose_by_number(column.header.stem, stems))
        for name, column in table.columns.items()
        if name != clock.column
    }
    reasons = {name: why for name, why in candidates_by_name.items() if isinstance(why, str)}
    notes = {"": clock.why, **reasons, **table.words}
    for name in clock.scores:
        if name != clock.column and isinstance(candidates_by_name.get(name), str) and clock.scores[name][0] >= 1.0:
            notes[name] = f"a clock {clock.scores[name][1]}, but {clock.column} is taken"
    candidates = [value for value in candidates_by_name.values() if isinstance(value, SignalCandidate)]
    scores = {name: [("time", *score)] for name, score in clock.scores.items()}
    for candidate in candidates:
        points = (candidate.signal.name, candidate.score, candidate.why)
        scores.setdefault(candidate.column.header.name, []).append(points)
    entries = _mapping_entries(candidates, joint_names, notes)
    if not entries:
        raise _no_signal_error(table, joint_names, notes)
    for name in notes:
        if name in table.columns and table.columns[name].notes and name != clock.column:
            notes[name] += "".join(f"; {note}" for note in table.columns[name].notes)
    time = {"column": clock.column, "unit": clock.unit}
    if period is not None or clock.period is not None:
        step = clock.period if period is None else u.quantity(period, u.TIME, "period")
        time = {"period": f"{step!r} s"}
    mapping = parse_mapping({"time": time, "column": entries}, str(table.path))
    mapped = {column for entry in mapping.column for column in entry.columns} | {"", clock.column}
    return MappingGuess(mapping, notes, {name: why for name, why in notes.items() if name not in mapped}, scores)


def _no_signal_error(table: LogTable, joints: Sequence[str], notes: Mapping[str, str]) -> InputError:
    """Return the error for a log in which no column looks like a signal."""
    reasons = "; ".join(f"{name}: {notes[name]}" for name in list(table.columns)[:8] if notes.get(name))
    headless = all(name.isdigit() for name in table.columns)
    header = "give it a header, such as time_s,angle_deg,pA_kPa_gauge,valve_V, or " if headless else ""
    several = not joints and any("may all be" in why for why in notes.values())
    header += "say which joints the names may have (`joints`), or " if several else ""
    right = f"{header}write a mapping file by hand that says which column is which signal ({reasons})"
    problem = "no column looks like a signal" + (": the table has no header" if headless else "")
    return InputError(problem, where=str(table.path), right=right)


def _describe_own_columns(mapping: LogMapping, table: LogTable) -> dict[str, str]:
    """Return notes on columns with layflat's own names, by column."""
    notes = {}
    if mapping.time is not None and mapping.time.column is not None:
        clock = table.columns[mapping.time.column]
        unit = "unit as in the header" if clock.header.unit else "in s, as nothing else is said"
        fault_note, _ = describe_stamps(clock.values, mapping.time.unit, [], f"{table.path}: {mapping.time.column}")
        notes[""] = "; ".join(("the clock by its name", unit, *clock.notes)) + fault_note
    for entry in mapping.column:
        column = table.columns[entry.columns[0]]
        unit = "unit as in the header" if column.header.unit else f"in {entry.unit}, as nothing else is said"
        notes[entry.columns[0]] = "; ".join(("one of layflat's own names", unit, *column.notes))
    return notes


def _covers_log(mapping: LogMapping, table: LogTable) -> bool:
    """Return whether all columns of a log have layflat's own names, and its clock and values are possible."""
    used = {column for entry in mapping.column for column in entry.columns} | {
        mapping.time.column if mapping.time else None
    }
    simulated = any(name.startswith("measured_angle") for name in used if name)
    unmapped = [name for name in table.columns if name not in used] if table.clock is None else find_unused(table, used)
    if unmapped and not simulated:
        return False
    stamps = next((column.stamps for column in table.columns.values() if column.stamps is not None), None)
    if table.clock is not None and not table.clock.unit and stamps is not None:
        return USUAL_STEPS[0] < median_step(stamps) < USUAL_STEPS[1]
    if mapping.time is not None and mapping.time.column is not None:
        clock = table.columns[mapping.time.column]
        step = median_step(clock.values)
        repeated = np.any(np.diff(clock.values) == 0.0)
        stated = clock.header.unit or USUAL_STEPS[0] < step < USUAL_STEPS[1]
        if not is_rising(clock.values) or repeated or not stated:
            return False
    for entry in mapping.column:
        column, signal = table.columns[entry.columns[0]], SIGNALS[entry.signal]
        magnitude = float(np.nanmax(np.abs(column.values), initial=0.0)) if np.isfinite(column.values).any() else 0.0
        stated = bool(column.header.unit)
        if not stated and (
            (signal.kind == u.ANGLE and magnitude > 4.0 * np.pi) or (signal.absolute and 0.0 < magnitude < 1e3)
        ):
            return False
    return True


def _mapping_entries(
    candidates: list[SignalCandidate], joints: list[str], notes: dict[str, str]
) -> list[dict[str, Any]]:
    """Return the entries of a mapping, one a channel, and add to `notes` why other columns are left out."""
    joint_by_group = _joints_of_groups(candidates, joints)
    channels: dict[str, list[tuple[SignalCandidate, str | None]]] = {}
    has_hoses = any(candidate.signal.name in {"pressure_a", "pressure_b"} for candidate in candidates)
    for candidate in candidates:
        joint = (candidate.joint or joint_by_group.get(candidate.group)) if candidate.signal.by_joint else None
        if candidate.signal.by_joint and joint is None and joint_by_group:
            notes[candidate.column.header.name] = f"{candidate.why}, but of none of the joints"
            continue
        channels.setdefault(channel_name(candidate.signal.name, joint), []).append((candidate, joint))
    entries: list[dict[str, Any]] = []
    for channel, rivals in channels.items():
        chosen = _choose_rival(channel, [candidate for candidate, _ in rivals], notes)
        if chosen is not None and chosen.signal.name == "pressure" and has_hoses:
            why = f"{chosen.why}, but of neither hose: name it in the mapping if it is one's"
            notes[chosen.column.header.name] = why
        elif chosen is not None:
            entries.append(_mapping_entry(chosen, rivals[0][1], notes))
    _set_gauges(entries, candidates, notes)
    return entries


def _choose_rival(channel: str, rivals: list[SignalCandidate], notes: dict[str, str]) -> SignalCandidate | None:
    """Return the candidate with most points for a channel; None where another is within `MIN_POINT_LEAD` points.

    Add to `notes` why the others are left out.
    """
    ranked = sorted(rivals, key=lambda rival: -rival.score)
    first, rest = ranked[0], ranked[1:]
    name = first.column.header.name
    for rival in rest:
        notes[rival.column.header.name] = (
            f"{rival.why}, but {name} is {channel} already, with {first.score:g} to {rival.score:g} points"
        )
        if np.array_equal(rival.column.values, first.column.values, equal_nan=True):
            notes[rival.column.header.name] = f"{rival.why}, but {name} is {channel} already, with the same values"
    equal = [
        rival
        for rival in rest
        if first.score - rival.score < MIN_POINT_LEAD and "same values" not in notes[rival.column.header.name]
    ]
    if not equal:
        return first
    names = " and ".join(rival.column.header.name for rival in (first, *equal))
    for rival in (first, *equal):
        notes[rival.column.header.name] = (
            f"{names} may all be {channel}: name one in the mapping, or all in one list if they measure the same"
        )
    return None


def _mapping_entry(candidate: SignalCandidate, joint: str | None, notes: dict[str, str]) -> dict[str, Any]:
    """Return the mapping's entry of a candidate, and add the reason to `notes`."""
    header, signal = candidate.column.header, candidate.signal
    unit, why = choose_unit(candidate.column, signal)
    entry: dict[str, Any] = {"from": header.name, "signal": signal.name, "unit": unit}
    entry |= {"joint": joint} if joint else {}
    notes[header.name] = f"{candidate.why}; {why}"
    if signal.absolute and header.gauge is not None:
        entry["gauge"] = header.gauge
        notes[header.name] += f"; {'gauge' if header.gauge else 'absolute'} as in the header"
    return entry


def _set_gauges(entries: list[dict[str, Any]], candidates: list[SignalCandidate], notes: dict[str, str]) -> None:
    """Set `gauge` in entries without stated zero, true if any falls below ambient or all stated are; add notes."""
    columns = {candidate.column.header.name: candidate.column for candidate in candidates}
    unsure = [e for e in entries if SIGNALS[e["signal"]].absolute and "gauge" not in e]
    below_ambient = {e["from"]: _falls_below_ambient(columns[e["from"]], e) for e in unsure}
    stated = {e["gauge"] for e in entries if SIGNALS[e["signal"]].absolute and "gauge" in e and e not in unsure}
    for entry in unsure:
        entry["gauge"] = any(below_ambient.values()) or stated == {True}
        by_others = below_ambient[entry["from"]] != entry["gauge"]
        reason = (
            "as others are"
            if by_others
            else "by how far it falls"
            if entry["gauge"]
            else "as it never falls below ambient"
        )
        notes[entry["from"]] += f"; {'gauge' if entry['gauge'] else 'absolute'} {reason}: check it"


def _falls_below_ambient(column: LogColumn, entry: Mapping[str, Any]) -> bool:
    """Return whether a pressure, read as absolute, falls below 0.8 of a standard atmosphere."""
    return float(np.nanmin(column.values)) * unit_conversion(entry["unit"], SIGNALS[entry["signal"]])[0] < 0.8 * AMBIENT


def _are_joints(candidates: list[SignalCandidate], numbers: list[str]) -> bool:
    """Return whether numbers in names are those of joints: at least one signal must occur with two of them.

    Numbers that each have another signal number the columns; a single number distinguishes nothing.
    """
    signals = Counter(candidate.signal.name for candidate in candidates if candidate.group)
    return len(numbers) > 1 and max(signals.values()) > 1


def _joints_of_groups(candidates: list[SignalCandidate], joints: list[str]) -> dict[str, str]:
    """Return the joint by the number in the names of its columns, "" for no number; empty where nothing is known."""
    unnamed = [candidate for candidate in candidates if candidate.signal.by_joint and not candidate.joint]
    numbers = sorted({candidate.group for candidate in unnamed if candidate.group}, key=int)
    if not _are_joints(unnamed, numbers):
        return dict.fromkeys(("", *numbers), joints[0]) if len(joints) == 1 else {}
    if not joints:
        return {number: f"joint{number}" for number in numbers}
    if len(numbers) > len(joints):
        angles = [candidate for candidate in unnamed if candidate.signal.name in {"angle", "demand"}]
        motion = {
            n: max((float(np.nanstd(f.column.values)) for f in angles if f.group == n), default=0.0) for n in numbers
        }
        numbers = sorted(sorted(numbers, key=lambda number: -motion[number])[: len(joints)], key=int)
    joint_by_group = dict(zip(numbers, joints, strict=False))
    return joint_by_group if len(joints) > 1 or not joint_by_group else joint_by_group | {"": joints[0]}
