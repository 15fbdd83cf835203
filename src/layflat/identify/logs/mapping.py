"""The mapping file: which column of a log is which signal, in which unit, turned which way.

    ambient = "1.013 bar"          # what gauge pressures count from; default: a standard atmosphere

    [time]
    column = "t"                   # not needed where each column has times of its own
    unit = "s"                     # or such as "0.1 ms"; or, for a log without a clock, period = "5 ms" alone

    [[column]]
    from = "rpa5"                  # or a list of columns that measure the same: their mean
    signal = "pressure_a"
    joint = "elbow"
    unit = "kPa"
    gauge = true                   # counts from ambient pressure; must be said of absolute pressures
    sign = 1
    offset = 0.0                   # in the column's own numbers
    scale = 1.0
    optional = false               # true: no mistake if the log has no such column

A sample becomes sign x (raw - offset) x scale x unit, and then ambient pressure is added if it counts from there. A
unit may have a number, so that an angle in per cent of 60 degrees is `unit = "0.6 deg"`.
"""

from collections.abc import Mapping as Tables
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.explain import explained
from layflat.description.hints import did_you_mean
from layflat.description.places import Steps
from layflat.description.tables import parsed
from layflat.description.text import read_text
from layflat.description.wrong import shown, wrong
from layflat.errors import InputError
from layflat.files import write_text
from layflat.identify.logs.table import Table
from layflat.identify.logs.vocabulary import AMBIENT, SIGNALS, channel_name, conversion

COMPLETE = "a mapping has [[column]] with from, signal and unit, and [time] with column and unit"


class TimeColumn(Part):
    """Clock of a log: a column and its unit, or the period of a log that has none."""

    column: str | None = None
    unit: str
    period: u.Time | None = None  # between two samples of a log without a clock

    @model_validator(mode="before")
    @classmethod
    def _is_one(cls, plain: Any) -> Any:
        if not isinstance(plain, dict) or "period" not in plain:
            return plain
        if "column" in plain:
            raise wrong("has a column and a period", "keep column, or period for a log without a clock")
        return {"unit": "s", **plain}

    @field_validator("unit")
    @classmethod
    def _is_time(cls, unit: str) -> str:
        try:
            _seconds(unit)
        except ValueError:
            raise wrong(f"{unit!r} is not a unit of a time", 'give one such as "s" or "ms"') from None
        return unit

    @property
    def seconds(self) -> float:
        """The unit in s."""
        return _seconds(self.unit)


def _seconds(unit: str) -> float:
    """Return a unit of time, which may have a number as "0.1 ms" has, in s."""
    return u.TIME.convert(unit if unit[:1].isdigit() or unit[:1] == "." else f"1 {unit}")


class MappedColumn(Part):
    """Column that a signal of a log is made from."""

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
    def _one_or_several(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        signal = SIGNALS.get(self.signal)
        if signal is None:
            raise wrong(f"{shown(self.signal)} is not a signal", did_you_mean(self.signal, SIGNALS))
        try:
            conversion(self.unit, signal)
        except ValueError as error:
            raise wrong(*str(error).split("; ")) from None
        if self.gauge is not None and not signal.absolute:
            raise wrong(f"gauge is said of {self.signal}, which is not an absolute pressure", "leave gauge out")
        if self.gauge is None and signal.absolute:
            raise wrong(
                f"{self.signal} does not say what it counts from",
                "say gauge = true (from ambient pressure) or gauge = false (absolute)",
            )
        if self.joint is not None and not signal.by_joint:
            raise wrong(f"{self.signal} belongs to no joint", "leave joint out")
        if len(set(self.columns)) < len(self.columns):
            raise wrong(f"from has {self.columns[0]!r} twice", "name each column once")
        return self

    @property
    def channel(self) -> str:
        """Signal and joint in one word."""
        return channel_name(self.signal, self.joint)


class Mapping(Part):
    """Meanings of a log's columns."""

    ambient: u.PositivePressure = AMBIENT
    time: TimeColumn | None = None
    column: tuple[MappedColumn, ...] = Field(min_length=1)


def read_mapping(path: str | Path) -> Mapping:
    """A mapping from its file; raise InputError as `mapping_of`."""
    where = str(path)
    right = "give a mapping file; `layflat log map` writes one to start from"
    plain = parsed(read_text(Path(path), where, right), where, 'unit = "kPa"')
    return mapping_of(plain, where)


def mapping_of(plain: Tables[str, Any], where: str = "mapping") -> Mapping:
    """A mapping from plain tables; raise InputError with the entry and value that is wrong, and what would be right."""
    try:
        mapping = Mapping.model_validate(plain)
    except ValidationError as error:
        raise explained(error, where, Mapping, complete=COMPLETE, written=_written) from None
    _check_together(mapping, where)
    return mapping


def _check_together(mapping: Mapping, where: str) -> None:
    """Entries that are right alone can contradict each other."""
    taken: dict[str, MappedColumn] = {}
    used: dict[str, str] = {} if mapping.time is None or mapping.time.column is None else {mapping.time.column: "time"}
    for entry in mapping.column:
        other = taken.setdefault(entry.channel, entry)
        if other is not entry and not (other.optional and entry.optional):
            what = f"{', '.join(other.columns)} and {', '.join(entry.columns)} are both {entry.channel}"
            right = "keep one, or put both in one list as from = [...] if they measure the same"
            raise InputError(what, where=where, right=right)
        for column in entry.columns:
            if used.setdefault(column, entry.channel) != entry.channel:
                what = f"column {column!r} is both {used[column]} and {entry.channel}"
                raise InputError(what, where=where, right="keep one")


def _written(steps: Steps, value: object) -> str:
    """A place as people count: "column 2.unit", with the column's name in the log where it is known."""
    named = [str(step) for step in steps]
    if len(steps) > 1 and steps[0] == "column" and isinstance(steps[1], int):
        named = [f"column {steps[1] + 1}", *named[2:]]
    if isinstance(value, dict) and isinstance(value.get("from"), str):
        named.append(value["from"])
    return ".".join(named)


def mapping_text(mapping: Mapping, notes: Tables[str, str] | None = None, head: str = "") -> str:
    """A mapping as TOML, with a comment at the top, and the notes by column as comments before each entry.

    Notes of columns that the mapping doesn't have stand at the end; "" is the clock's.
    """
    import tomli_w  # noqa: PLC0415

    left = dict(notes or {})
    parts = [_comment(head)] if head else []
    if mapping.ambient != AMBIENT:
        parts.append(tomli_w.dumps({"ambient": f"{mapping.ambient!r} Pa"}))
    if mapping.time is not None:
        period = mapping.time.period
        clock = mapping.time.model_dump(exclude_none=True) if period is None else {"period": f"{period!r} s"}
        parts.append(_comment(left.pop("", "")) + tomli_w.dumps({"time": clock}))
    for entry in mapping.column:
        plain = entry.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True)
        plain["from"] = entry.columns[0] if len(entry.columns) == 1 else list(entry.columns)
        told = "; ".join(filter(None, (left.pop(column, "") for column in entry.columns)))
        parts.append(_comment(told) + "[[column]]\n" + tomli_w.dumps(plain))
    if left:
        parts.append(_comment("Left out:\n" + "\n".join(f"  {column}: {note}" for column, note in left.items())))
    return "\n".join(parts)


def _comment(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())


def write_mapping(mapping: Mapping, path: str | Path, notes: Tables[str, str] | None = None, head: str = "") -> Path:
    """Write a mapping file that `read_mapping` takes back; raise OutputError if it can't be written there."""
    return write_text(Path(path), mapping_text(mapping, notes, head))


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
