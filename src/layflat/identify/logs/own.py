"""Logs whose names are our own, a simulated run among them: they need no mapping file."""

from typing import Any

from layflat.identify.logs.mapping import Mapping, mapping_of
from layflat.identify.logs.table import Table
from layflat.identify.logs.vocabulary import SIGNALS

CLOCKS = ("time", "t")

SENSED = {"measured_angle": "angle", "brake_share": "brake", "dither_share": "dither"}
"""What the sensors of a simulated run have seen, and what its controller asked for besides, by the signals."""


def own_mapping(table: Table) -> Mapping | None:
    """The mapping of a log whose columns are called "angle.large", "voltage.large", "supply" and the like; else None.

    Units are those that the file states, SI where it states none; pressures are absolute unless it says otherwise. A
    simulated run has true angles and pressures beside what sensors have seen: a fit gets what a rig would have given.
    """
    columns = [entry for name in table.columns if (entry := _entry(name, table)) is not None]
    if any(entry["from"].startswith("measured_angle") for entry in columns):
        hidden = ("angle", "pressure_a", "pressure_b")
        columns = [entry for entry in columns if entry["from"].partition(".")[0] not in hidden]
    stems = {column.header.stem: column.header for column in table.columns.values()}
    clock = next((stems[name] for name in CLOCKS if name in stems), None)
    if not columns or (clock is None and table.clock is None):
        return None
    plain: dict[str, object] = {"column": columns}
    if table.clock is None and clock is not None:
        plain["time"] = {"column": clock.name, "unit": clock.unit or "s"}
    return mapping_of(plain, str(table.path))


def _entry(name: str, table: Table) -> dict[str, Any] | None:
    header = table.columns[name].header
    word, _, joint = header.stem.partition(".")
    signal = SIGNALS.get(SENSED.get(word, word))
    if signal is None or (joint and not signal.by_joint):
        return None
    entry: dict[str, Any] = {"from": name, "signal": signal.name, "unit": header.unit or signal.unit}
    return entry | ({"joint": joint} if joint else {}) | ({"gauge": bool(header.gauge)} if signal.absolute else {})
