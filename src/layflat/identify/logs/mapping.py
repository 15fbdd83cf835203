"""Mapping file: the signal, unit and sign of each column of a log.

    ambient = "1.013 bar"          # zero of gauge pressures; default: a standard atmosphere

    [time]
    column = "t"                   # not needed where each column has its own stamps
    unit = "s"                     # or "0.1 ms" and the like; for a log without a clock: period = "5 ms" alone

    [[column]]
    from = "rpa5"                  # or a list of columns that measure the same: their mean
    signal = "pressure_a"
    joint = "elbow"
    unit = "kPa"
    gauge = true                   # relative to ambient pressure; required for pressures of hoses, chambers and supply
    sign = 1
    offset = 0.0                   # in the column's own numbers
    scale = 1.0
    optional = false               # true: no error if the log has no such column

A sample becomes sign x (raw - offset) x scale x unit, plus the ambient pressure if it is a gauge pressure. A unit
may have a number, so that an angle in per cent of 60 degrees is `unit = "0.6 deg"`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.explain import explain_error
from layflat.description.places import Steps
from layflat.description.tables import parse_toml
from layflat.description.text import read_text
from layflat.description.wrong import did_you_mean, shown, value_error
from layflat.errors import InputError
from layflat.files import write_text
from layflat.identify.logs.table import LogTable
from layflat.identify.logs.vocabulary import AMBIENT, SIGNALS, channel_name, unit_conversion

COMPLETE_MAPPING = "a mapping has [[column]] with from, signal and unit, and [time] with column and unit"


class TimeColumn(Part):
    """Clock of a log: a column and its unit, or the period of a log that has none."""

    column: str | None = None
    unit: str
    period: u.Time | None = None  # of the samples of a log without a clock

    @model_validator(mode="before")
    @classmethod
    def _check_column_or_period(cls, plain: Any) -> Any:
        """Return the table with unit "s" where only a period is given; refuse a column beside a period."""
        if not isinstance(plain, dict) or "period" not in plain:
            return plain
        if "column" in plain:
            raise value_error("has a column and a period", "keep column, or period for a log without a clock")
        return {"unit": "s", **plain}

    @field_validator("unit")
    @classmethod
    def _check_time_unit(cls, unit: str) -> str:
        """Return the unit; refuse one that is not of a time."""
        try:
            _unit_seconds(unit)
        except ValueError:
            raise value_error(f"{unit!r} is not a unit of a time", 'give one such as "s" or "ms"') from None
        return unit

    @property
    def seconds(self) -> float:
        """Size of the unit, s."""
        return _unit_seconds(self.unit)


def _unit_seconds(unit: str) -> float:
    """Return the size of a unit of time, s; it may have a number, as "0.1 ms" has."""
    return u.TIME.convert(unit if unit[:1].isdigit() or unit[:1] == "." else f"1 {unit}")


class MappedColumn(Part):
    """Column of a log, or several that measure the same, and its signal."""

    columns: tuple[str, ...] = Field(alias="from", min_length=1)
    signal: str
    joint: str | None = None
    unit: str
    gauge: bool | None = None
    sign: Literal[1, -1] = 1
    offset: float = 0.0
    scale: Annotated[float, Field(gt=0.0)] = 1.0
    optional: bool = False

    @field_validator("columns", mode="before")
    @classmethod
    def _wrap_single_column(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        """Refuse an unknown signal, and a unit, gauge or joint that does not fit it."""
        signal = SIGNALS.get(self.signal)
        if signal is None:
            raise value_error(f"{shown(self.signal)} is not a signal", did_you_mean(self.signal, SIGNALS))
        try:
            unit_conversion(self.unit, signal)
        except ValueError as error:
            raise value_error(*str(error).split("; ")) from None
        if self.gauge is not None and not signal.absolute:
            raise value_error(f"gauge does not apply to {self.signal}: it is no absolute pressure", "leave gauge out")
        if self.gauge is None and signal.absolute:
            raise value_error(
                f"{self.signal} does not say what it counts from",
                "say gauge = true (from ambient pressure) or gauge = false (absolute)",
            )
        if self.joint is not None and not signal.by_joint:
            raise value_error(f"{self.signal} belongs to no joint", "leave joint out")
        if len(set(self.columns)) < len(self.columns):
            raise value_error(f"from has {self.columns[0]!r} twice", "name each column once")
        return self

    @property
    def channel(self) -> str:
        """Name of signal and joint, such as "angle.elbow"."""
        return channel_name(self.signal, self.joint)


class LogMapping(Part):
    """Signals of a log's columns, its clock, and its ambient pressure."""

    ambient: u.PositivePressure = AMBIENT
    time: TimeColumn | None = None
    column: tuple[MappedColumn, ...] = Field(min_length=1)


def read_mapping(path: str | Path) -> LogMapping:
    """Read a mapping from its file; raise InputError as `parse_mapping` does."""
    where = str(path)
    right = "give a mapping file; `layflat log map` writes one to start from"
    plain = parse_toml(read_text(Path(path), where, right), where, 'unit = "kPa"')
    return parse_mapping(plain, where)


def parse_mapping(plain: Mapping[str, Any], where: str = "mapping") -> LogMapping:
    """Return the mapping of plain tables; raise InputError with entry and value that are wrong, and the advice."""
    try:
        mapping = LogMapping.model_validate(plain)
    except ValidationError as error:
        raise explain_error(error, where, LogMapping, complete=COMPLETE_MAPPING, written=_entry_location) from None
    _check_conflicts(mapping, where)
    return mapping


def _check_conflicts(mapping: LogMapping, where: str) -> None:
    """Raise InputError if two entries, not both optional, are one channel, or one column has two meanings."""
    entry_by_channel: dict[str, MappedColumn] = {}
    meaning_by_column: dict[str, str] = (
        {} if mapping.time is None or mapping.time.column is None else {mapping.time.column: "time"}
    )
    for entry in mapping.column:
        other = entry_by_channel.setdefault(entry.channel, entry)
        if other is not entry and not (other.optional and entry.optional):
            problem = f"{', '.join(other.columns)} and {', '.join(entry.columns)} are both {entry.channel}"
            right = "keep one, or put both in one list as from = [...] if they measure the same"
            raise InputError(problem, where=where, right=right)
        for column in entry.columns:
            if meaning_by_column.setdefault(column, entry.channel) != entry.channel:
                problem = f"column {column!r} is both {meaning_by_column[column]} and {entry.channel}"
                raise InputError(problem, where=where, right="keep one")


def _entry_location(steps: Steps, value: object) -> str:
    """Return a key as people count: "column 2.unit", with the column's name in the log where it is known."""
    named = [str(step) for step in steps]
    if len(steps) > 1 and steps[0] == "column" and isinstance(steps[1], int):
        named = [f"column {steps[1] + 1}", *named[2:]]
    if isinstance(value, dict) and isinstance(value.get("from"), str):
        named.append(value["from"])
    return ".".join(named)


def format_mapping(mapping: LogMapping, notes: Mapping[str, str] | None = None, head: str = "") -> str:
    """Return a mapping as TOML, with notes as comments.

    Args:
        mapping: mapping to be written.
        notes: notes by column, before its entry; those of unmapped columns come last, and "" is the clock's.
        head: comment at the top.
    """
    import tomli_w  # noqa: PLC0415

    remaining = dict(notes or {})
    parts = [_comment_lines(head)] if head else []
    if mapping.ambient != AMBIENT:
        parts.append(tomli_w.dumps({"ambient": f"{mapping.ambient!r} Pa"}))
    if mapping.time is not None:
        period = mapping.time.period
        clock = mapping.time.model_dump(exclude_none=True) if period is None else {"period": f"{period!r} s"}
        parts.append(_comment_lines(remaining.pop("", "")) + tomli_w.dumps({"time": clock}))
    for entry in mapping.column:
        plain = entry.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True)
        plain["from"] = entry.columns[0] if len(entry.columns) == 1 else list(entry.columns)
        note = "; ".join(filter(None, (remaining.pop(column, "") for column in entry.columns)))
        parts.append(_comment_lines(note) + "[[column]]\n" + tomli_w.dumps(plain))
    if remaining:
        parts.append(
            _comment_lines("Left out:\n" + "\n".join(f"  {column}: {note}" for column, note in remaining.items()))
        )
    return "\n".join(parts)


def _comment_lines(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())


def write_mapping(
    mapping: LogMapping, path: str | Path, notes: Mapping[str, str] | None = None, head: str = ""
) -> Path:
    """Write a mapping file for `read_mapping` and return its path; raise OutputError if it can't be written there.

    Args:
        mapping: mapping to be written.
        path: path of the file.
        notes: notes by column, as comments: see `format_mapping`.
        head: comment at the top.
    """
    return write_text(Path(path), format_mapping(mapping, notes, head))


CLOCK_NAMES = ("time", "t")

SENSED_SIGNALS = {"measured_angle": "angle", "brake_share": "brake", "dither_share": "dither"}
"""Signals by the names of a simulated run: measurements of its sensors, and further commands of its controller."""


def map_own_names(table: LogTable) -> LogMapping | None:
    """Return the mapping of a log with layflat's names: "angle.large", "voltage.large", "supply"; None for other logs.

    Units are those that the file states, SI where it states none; pressures are absolute unless it says otherwise. Of a
    simulated run, true angles and pressures are left out, and the measurements of its sensors are used, as of a rig.
    """
    columns = [entry for name in table.columns if (entry := _own_name_entry(name, table)) is not None]
    if any(entry["from"].startswith("measured_angle") for entry in columns):
        hidden = ("angle", "pressure_a", "pressure_b")
        columns = [entry for entry in columns if entry["from"].partition(".")[0] not in hidden]
    stems = {column.header.stem: column.header for column in table.columns.values()}
    clock = next((stems[name] for name in CLOCK_NAMES if name in stems), None)
    if not columns or (clock is None and table.clock is None):
        return None
    plain: dict[str, object] = {"column": columns}
    if table.clock is None and clock is not None:
        plain["time"] = {"column": clock.name, "unit": clock.unit or "s"}
    return parse_mapping(plain, str(table.path))


def _own_name_entry(name: str, table: LogTable) -> dict[str, Any] | None:
    """Return the mapping's entry of a column with one of layflat's own names; None for others."""
    header = table.columns[name].header
    word, _, joint = header.stem.partition(".")
    signal = SIGNALS.get(SENSED_SIGNALS.get(word, word))
    if signal is None or (joint and not signal.by_joint):
        return None
    entry: dict[str, Any] = {"from": name, "signal": signal.name, "unit": header.unit or signal.unit}
    return entry | ({"joint": joint} if joint else {}) | ({"gauge": bool(header.gauge)} if signal.absolute else {})
