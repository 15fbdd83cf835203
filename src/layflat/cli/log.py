"""Commands about bench logs: log check, log map; those about logs of a rig stand in recorded.py."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import print_table
from layflat.cli.bars import bar, busy
from layflat.cli.lazy import LazyTyper

if TYPE_CHECKING:
    import xarray

    from layflat.identify.logs.guess import Guess
    from layflat.identify.logs.mapping import MappedColumn
    from layflat.identify.logs.table import Table
    from layflat.machine import Machine

logs = LazyTyper(
    "log",
    "Show, check, convert and repair logs of test benches and rigs.",
    {"check": "log", "map": "log", "info": "recorded", "repair": "recorded", "plot": "recorded", "export": "recorded"},
)


@logs.callback()
def log() -> None:
    """Group the commands about logs."""


LogFile = Annotated[Path, typer.Argument(metavar="LOG", help="CSV, Parquet, NetCDF or MCAP")]
MappingFile = Annotated[
    Path | None, typer.Option("--mapping", metavar="FILE", help="what its columns are; not needed for our own names")
]
OfMachine = Annotated[
    str | None, typer.Option("--machine", metavar="NAME|FILE", help="the machine that it was recorded on")
]


@logs.command("check")
def check_log(
    log: LogFile,
    mapping: MappingFile = None,
    machine: OfMachine = None,
    cycle: Annotated[str | None, typer.Option(help="period to resample to; default: the log's own")] = None,
) -> None:
    """Check a log: its channels, and what is wrong with them. Exit status 2 if no fit would make sense."""
    from layflat.identify.logs import check, read_log, refuse  # noqa: PLC0415

    described = _machine(machine)
    table = _read(log)
    with busy("checking"):
        data = read_log(table, mapping, joints=_joints(described), cycle=cycle)
        issues = check(data, described)
    period = data.attrs["log_period"]
    title = f"{log.name}: {data.sizes['time']} instants, one every {period * 1e3:.4g} ms"
    rows, filled = _channels(data)
    print_table(["signal", "joint", "column", "unit", "from", "to", "samples", "missing"], rows, title)
    if filled:
        typer.echo("samples: those of the log + instants between them that are filled in")
    if issues:
        typer.echo()
        rows = [[f.severity, f.channel, f.text, f.right] for f in issues]
        print_table(["severity", "channel", "found", "action"], rows)
    refuse(issues, str(log))
    typer.echo(f"{log}: sound" if not issues else f"{log}: no errors")


@logs.command("map")
def map_log(
    log: LogFile,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[LOG's name]-mapping.toml")] = None,
    machine: OfMachine = None,
    period: Annotated[
        str | None, typer.Option(help='between samples, such as "5 ms", of a log without a clock')
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="show what each column may be, with points")] = False,
) -> None:
    """Guess what a log's columns are, and write a mapping file to look through and correct."""
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.identify.logs import guess_mapping, write_mapping  # noqa: PLC0415

    place = out or Path(f"{log.stem}-mapping.toml")
    check_file(place)
    table = _read(log)
    guess = guess_mapping(table, _joints(_machine(machine)), period)
    for note in table.notes:
        typer.echo(f"{log.name}: {note}")
    if explain:
        _explain(table, guess)
    rows = _clock_row(table, guess)
    rows += [
        [
            ", ".join(entry.columns),
            _stated(table, entry.columns[0]),
            entry.channel,
            _unit_of(entry),
            guess.notes.get(entry.columns[0], ""),
        ]
        for entry in guess.mapping.column
    ]
    print_table(["column", "stated", "taken for", "unit", "why"], rows)
    if guess.left:
        typer.echo()
        print_table(
            ["left out", "stated", "why"], [[name, _stated(table, name), why] for name, why in guess.left.items()]
        )
    left = len(guess.left)
    head = f"Guessed from {log.name} by `layflat log map`: look through every entry before you use it."
    typer.echo(f"{left} columns are left out" if left != 1 else "1 column is left out")
    typer.echo(f"wrote {write_mapping(guess.mapping, place, guess.notes, head)}: a guess, correct it before you use it")


def _clock_row(table: "Table", guess: "Guess") -> list[list[str]]:
    """Return the row of the clock: a column, or rows that are evenly spaced; nothing without one."""
    clock, why = guess.mapping.time, guess.notes.get("", "")
    if clock is None:
        return []
    if clock.period is not None:
        return [["(each row)", "", "time", f"{1e3 * clock.period:.6g} ms", why]]
    return [[clock.column, _stated(table, clock.column), "time", clock.unit, why]] if clock.column else []


def _read(log: Path) -> "Table":
    """Read a log's file with a bar."""
    from layflat.identify.logs import read_table  # noqa: PLC0415

    with bar("reading", 1.0, "TimeRemainingColumn") as update:
        return read_table(log, lambda fraction: update(completed=fraction))


def _stated(table: "Table", name: str) -> str:
    """Return the unit that a column's header states, in its own words where it is not understood."""
    header = table.columns[name].header if name in table.columns else table.clock
    if header is None:
        return ""
    zero = {True: " gauge", False: " absolute", None: ""}[header.gauge]
    return f"{header.unit or header.unknown}{zero}".strip()


def _unit_of(entry: "MappedColumn") -> str:
    return entry.unit if entry.gauge is None else f"{entry.unit} {'gauge' if entry.gauge else 'absolute'}"


def _explain(table: "Table", guess: "Guess") -> None:
    """Print what each column may be."""
    rows = []
    for name in table.columns:
        may_be = guess.scores.get(name, [("nothing", 0.0, guess.notes.get(name, ""))])
        rows += [[name, _stated(table, name), signal, f"{points:g}", why] for signal, points, why in may_be]
    print_table(
        ["column", "stated", "may be", "points", "why"],
        rows,
        "What each column may be: its name counts 4, layflat's own 6, a unit that fits 3",
    )
    typer.echo()


def _machine(name: str | None) -> "Machine | None":
    from layflat.machine import load  # noqa: PLC0415

    return load(name) if name is not None else None


def _joints(machine: "Machine | None") -> list[str] | None:
    return list(machine.joints) if machine is not None else None


def _channels(data: "xarray.Dataset") -> tuple[list[list[str]], bool]:
    """A row for each channel with its source, range and samples, in units that people read; whether any is filled."""
    from layflat.identify.logs.checks.channels import checked_log  # noqa: PLC0415

    rows, any_filled = [], False
    for channel in checked_log(data, None).channels.values():
        unit, size = channel.signal.shown
        known = channel.known / size
        ends = [f"{known.min():.4g}", f"{known.max():.4g}"] if known.size else ["", ""]
        missing = channel.values.size - known.size
        samples = channel.source.get("samples", known.size)
        filled = known.size - samples
        any_filled |= filled > 0
        counts = [f"{samples} + {filled}" if filled > 0 else str(samples), str(missing or "")]
        rows.append([channel.signal.name, channel.joint or "", channel.source.get("column", ""), unit, *ends, *counts])
    return rows, any_filled
