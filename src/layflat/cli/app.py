"""The application, and what its commands share. Each command is imported when it is used."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat._version import __version__
from layflat.cli.lazy import LazyTyper
from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.design import Finding
    from layflat.machine import Machine

app = LazyTyper(
    "layflat",
    "Design, simulate and control robot joints made of layflat hose.",
    {
        "machines": "describe",
        "show": "describe",
        "check": "describe",
        "schema": "describe",
        "docs": "docs",
        "design": "design",
        "size": "design",
        "size-arm": "size_arm",
        "arm-tasks": "size_arm",
        "simulate": "simulate",
        "loop": "simulate",
        "motions": "motion",
        "motion": "motion",
        "learn": "learn",
        "tune": "tune",
        "studies": "study",
        "study": "study",
        "reproduce": "reproduce",
        "beyond": "beyond",
        "excite": "identify",
        "identify": "identify",
        "log": "log:logs",
        "rig": "rig:rigs",
        "panel": "panel",
        "studio": "studio",
        "cells": "pack",
        "pack": "pack",
        "arm": "arm:arms",
        "arm-model": "arm",
        "view": "view",
    },
)


def show_version(asked: bool) -> None:
    """Print the version and end, where it is asked for."""
    if asked:
        typer.echo(f"layflat {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=show_version, help="Print the version and exit.")
    ] = False,
) -> None:
    """Take the options that stand before any command."""


MachineName = Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in machine or description file")]
Out = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="folder for the results")]
Device = Annotated[str, typer.Option(metavar="cpu|cuda", help="that makes the runs; cuda needs the extra `gpu`")]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="of the random numbers; the same seed gives the same")]


def expanded(command: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a command that takes a dataclass of options: typer sees an option for each of its fields.

    A field with metadata is a table of options, by their names: typer sees all of them, with these annotations.
    """
    own = signature(command, eval_str=True).parameters
    name = next(key for key, one in own.items() if is_dataclass(one.annotation))
    options: Any = own[name].annotation
    tables = {one.name: one.metadata for one in fields(options) if one.metadata}
    seen = signature(options, eval_str=True).parameters

    @wraps(command)
    def called(**given: Any) -> Any:
        found = {key: {each: given.pop(each) for each in table} for key, table in tables.items()}
        found |= {key: given.pop(key) for key in seen if key not in tables}
        return command(**given, **{name: options(**found)})

    def parts(key: str, one: Parameter) -> Iterator[Parameter]:
        if key in tables:
            notes = tables[key].items()
            yield from (Parameter(each, Parameter.KEYWORD_ONLY, default=None, annotation=note) for each, note in notes)
        else:
            yield one.replace(kind=Parameter.KEYWORD_ONLY)

    inside = [part for key, one in seen.items() for part in parts(key, one)]
    shown = [one for key in own for one in (inside if key == name else parts("", own[key]))]
    called.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    called.__annotations__ = {one.name: one.annotation for one in shown}
    return called


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, such as "1 run" and "2 runs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


WIDTH = 100  # columns that a table may take


def print_table(columns: list[str], rows: list[list[str]], title: str = "") -> None:
    """Print a table that fits 100 columns, with every text as it is: "p [kPa]" and ":key:" are no markup."""
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    table = Table(title=Text(title) if title else None, title_justify="left", header_style="bold", show_edge=False)
    for column in columns:
        table.add_column(Text(column), overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False)
    console.width = min(console.width if console.is_terminal else WIDTH, WIDTH)
    console.print(table)


def print_findings(findings: "Iterable[Finding]") -> None:
    """Print what the design rules found, if anything."""
    rows = [[f.severity, f.where, f.what, f.right] for f in findings]
    if rows:
        print_table(["severity", "where", "found", "action"], rows)


def known_joint(machine: "Machine", joint: str) -> str:
    """Return the name given to --joint, of a joint of this machine (InputError: the machine has no such joint)."""
    if joint not in machine.joints:
        raise InputError(f"unknown joint {joint!r}", where="--joint", right=f"give {' or '.join(machine.joints)}")
    return joint


@contextmanager
def naming_options(options: Mapping[str, str]) -> Iterator[None]:
    """Name in errors the option that the user gave, which stands in `options` by the argument that it became."""
    try:
        yield
    except InputError as error:
        if error.where not in options:
            raise
        raise InputError(error.what, where=options[error.where], right=error.right) from None
