"""Commands about bench logs: log check, log map; those about logs of a rig stand in recorded.py."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import bar, busy
from layflat.cli.common import naming_options, print_table
from layflat.cli.completers import complete_name
from layflat.cli.groups import logs

if TYPE_CHECKING:
    import xarray

    from layflat.identify.logs.guess import MappingGuess
    from layflat.identify.logs.mapping import MappedColumn
    from layflat.identify.logs.table import LogTable
    from layflat.machine import Machine

LogFile = Annotated[Path, typer.Argument(metavar="LOG", help="CSV, Parquet, NetCDF or MCAP")]
MappingFile = Annotated[
    Path | None, typer.Option("--mapping", metavar="FILE", help="what its columns are; not needed for our own names")
]
OfMachine = Annotated[
    str | None,
    typer.Option(
        "--machine",
        metavar="NAME|FILE",
        help="the machine that it was recorded on",
        autocompletion=complete_name("machine"),
    ),
]


@logs.register("check", "log.csv --machine paper-arm", "log.csv --mapping log-mapping.toml")
def check_log(
    log: LogFile,
    mapping: MappingFile = None,
    machine: OfMachine = None,
    cycle: Annotated[str | None, typer.Option(help="period to resample to; default: the log's own")] = None,
) -> None:
    """Check a log: its channels, and what is wrong with them.

    Exit status 2 if no fit would make sense.
    """
    from layflat.identify.logs import find_issues, raise_first_error, read_log  # noqa: PLC0415

    described = _machine(machine)
    table = _read(log)
    with naming_options({"joints": "--machine"}), busy("checking"):
        data = read_log(table, mapping, joints=_joints(described), cycle=cycle)
        issues = find_issues(data, described)
    period = data.attrs["log_period"]
    title = f"{log.name}: {data.sizes['time']} instants, one every {period * 1e3:.4g} ms"
    rows, filled = _channel_rows(data)
    print_table(["signal", "joint", "column", "unit", "from", "to", "samples", "missing"], rows, title)
    if filled:
        typer.echo("samples: those of the log + instants between them that are filled in")
    if issues:
        typer.echo()
        rows = [[f.severity, f.channel, f.text, f.right] for f in issues]
        print_table(["severity", "channel", "found", "action"], rows)
    raise_first_error(issues, str(log))
    typer.echo(f"{log}: sound" if not issues else f"{log}: no errors")


@logs.register("map", "log.csv --machine paper-arm", "log.csv --explain")
def map_log(
    log: LogFile,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[LOG's name]-mapping.toml")] = None,
    machine: OfMachine = None,
    period: Annotated[
        str | None, typer.Option(help='between samples, such as "5 ms", of a log without a clock')
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="show what each column may be, with points")] = False,
) -> None:
    """Guess what a log's columns are, and write a mapping file.

    Look through the file and correct it before you use it.
    """
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.identify.logs import guess_mapping, write_mapping  # noqa: PLC0415

    place = out or Path(f"{log.stem}-mapping.toml")
    check_file(place)
    table = _read(log)
    with naming_options({"joints": "--machine", "period": "--period"}):
        guess = guess_mapping(table, _joints(_machine(machine)), period)
    for note in table.notes:
        typer.echo(f"{log.name}: {note}")
    if explain:
        _print_candidates(table, guess)
    rows = _clock_row(table, guess)
    rows += [
        [
            ", ".join(entry.columns),
            _stated_unit(table, entry.columns[0]),
            entry.channel,
            _unit_of(entry),
            guess.notes.get(entry.columns[0], ""),
        ]
        for entry in guess.mapping.column
    ]
    print_table(["column", "stated", "taken for", "unit", "why"], rows)
    if guess.ignored:
        typer.echo()
        print_table(
            ["left out", "stated", "why"],
            [[name, _stated_unit(table, name), why] for name, why in guess.ignored.items()],
        )
    left = len(guess.ignored)
    head = f"Guessed from {log.name} by `layflat log map`: look through every entry before you use it."
    typer.echo(f"{left} columns are left out" if left != 1 else "1 column is left out")
    typer.echo(f"wrote {write_mapping(guess.mapping, place, guess.notes, head)}: a guess, correct it before you use it")


def _clock_row(table: "LogTable", guess: "MappingGuess") -> list[list[str]]:
    """Return the row of the clock: a column, or rows that are evenly spaced; nothing without one."""
    clock, why = guess.mapping.time, guess.notes.get("", "")
    if clock is None:
        return []
    if clock.period is not None:
        return [["(each row)", "", "time", f"{1e3 * clock.period:.6g} ms", why]]
    return [[clock.column, _stated_unit(table, clock.column), "time", clock.unit, why]] if clock.column else []


def _read(log: Path) -> "LogTable":
    """Return the table of a log's file; a progress bar shows the reading."""
    from layflat.identify.logs import read_table  # noqa: PLC0415

    with bar("reading", 1.0, "TimeRemainingColumn") as update:
        return read_table(log, lambda fraction: update(completed=fraction))


def _stated_unit(table: "LogTable", name: str) -> str:
    """Return the unit that a column's header states, in its own words where it is not understood."""
    header = table.columns[name].header if name in table.columns else table.clock
    if header is None:
        return ""
    zero = {True: " gauge", False: " absolute", None: ""}[header.gauge]
    return f"{header.unit or header.unknown}{zero}".strip()


def _unit_of(entry: "MappedColumn") -> str:
    return entry.unit if entry.gauge is None else f"{entry.unit} {'gauge' if entry.gauge else 'absolute'}"


def _print_candidates(table: "LogTable", guess: "MappingGuess") -> None:
    """Print the possible signals of each column."""
    rows = []
    for name in table.columns:
        may_be = guess.scores.get(name, [("nothing", 0.0, guess.notes.get(name, ""))])
        rows += [[name, _stated_unit(table, name), signal, f"{points:g}", why] for signal, points, why in may_be]
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


def _channel_rows(data: "xarray.Dataset") -> tuple[list[list[str]], bool]:
    """Return a row for each channel with source, range and samples, in units of display; and whether any is filled."""
    from layflat.identify.logs.checks.channels import prepare_log  # noqa: PLC0415

    rows, any_filled = [], False
    for channel in prepare_log(data, None).channels.values():
        unit, size = channel.signal.display_unit
        values = channel.samples / size
        ends = [f"{values.min():.4g}", f"{values.max():.4g}"] if values.size else ["", ""]
        missing = channel.values.size - values.size
        samples = channel.source.get("samples", values.size)
        filled = values.size - samples
        any_filled |= filled > 0
        counts = [f"{samples} + {filled}" if filled > 0 else str(samples), str(missing or "")]
        rows.append([channel.signal.name, channel.joint or "", channel.source.get("column", ""), unit, *ends, *counts])
    return rows, any_filled
