"""Arguments, options, tables and messages that commands share."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import Field, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.completers import complete_choice, complete_joint, complete_name
from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.design import Finding
    from layflat.machine import Machine

MACHINE_HELP = "built-in machine or description file"
MachineName = Annotated[
    str, typer.Argument(metavar="NAME|FILE", help=MACHINE_HELP, autocompletion=complete_name("machine"))
]
JointName = Annotated[
    str | None, typer.Option("--joint", metavar="JOINT", help="[default: all joints]", autocompletion=complete_joint)
]
Out = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="folder for the results")]
Device = Annotated[
    str,
    typer.Option(
        metavar="cpu|cuda",
        help="that makes the runs; cuda needs the extra `gpu`",
        autocompletion=complete_choice("cpu", "cuda"),
    ),
]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="of the random numbers; the same seed gives the same")]


def expanded(command: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a command that takes dataclasses of options: typer sees an option for each of their fields.

    A field with metadata is a table of options, by their names: typer sees all of them, with these annotations.
    """
    parameters = signature(command, eval_str=True).parameters
    groups: dict[str, Any] = {key: one.annotation for key, one in parameters.items() if is_dataclass(one.annotation)}

    @wraps(command)
    def called(**arguments: Any) -> Any:
        """Call the command with its groups of options built from single ones."""

        def pop_values(option_field: Field[Any]) -> Any:
            """Take the value of a field from the arguments, or those of its table of options by name."""
            return (
                {each: arguments.pop(each) for each in option_field.metadata}
                if option_field.metadata
                else arguments.pop(option_field.name)
            )

        options = {key: group(**{one.name: pop_values(one) for one in fields(group)}) for key, group in groups.items()}
        return command(**arguments, **options)

    def options_of(group: Any) -> Iterator[Parameter]:
        """Yield the parameters that typer sees for the fields of a group."""
        shown_parameters = signature(group, eval_str=True).parameters
        for one in fields(group):
            for each, note in one.metadata.items():
                yield Parameter(each, Parameter.KEYWORD_ONLY, default=None, annotation=note)
            if not one.metadata:
                yield shown_parameters[one.name].replace(kind=Parameter.KEYWORD_ONLY)

    def parts(key: str) -> Iterator[Parameter]:
        """Yield the parameters of a group of options, or the single parameter of this name."""
        if key in groups:
            yield from options_of(groups[key])
        else:
            yield parameters[key].replace(kind=Parameter.KEYWORD_ONLY)

    shown = [part for key in parameters for part in parts(key)]
    called.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    called.__annotations__ = {one.name: one.annotation for one in shown}
    return called


def count_noun(count: int, noun: str) -> str:
    """Return a count with its noun, such as "1 run" and "2 runs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


WIDTH = 100  # columns that a table may take
KEY_WIDTH = 24  # columns that keys in a table's first column may take without a break


def print_table(columns: list[str], rows: list[list[str]], title: str = "") -> None:
    """Print a table at most `WIDTH` columns wide; texts hold no markup, so "p [kPa]" and ":key:" stay as they are.

    Args:
        columns: heads of the columns.
        rows: texts, one for each column.
        title: above the table; "" for none.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    table = Table(title=Text(title) if title else None, title_justify="left", header_style="bold", show_edge=False)
    whole_keys = max((len(row[0]) for row in rows), default=0) <= KEY_WIDTH
    for number, column in enumerate(columns):
        table.add_column(Text(column), overflow="fold", no_wrap=number == 0 and whole_keys)
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False)
    console.width = min(console.width if console.is_terminal else WIDTH, WIDTH)
    console.print(table)


def print_findings(findings: "Iterable[Finding]") -> None:
    """Print the findings of the design rules as a table; nothing if there are none."""
    rows = [[f.severity, f.where, f.what, f.right] for f in findings]
    if rows:
        print_table(["severity", "where", "found", "action"], rows)


def check_joint(machine: "Machine", joint: str) -> str:
    """Return the joint named by --joint (InputError: the machine has no such joint)."""
    if joint not in machine.joints:
        raise InputError(f"unknown joint {joint!r}", where="--joint", right=f"give {' or '.join(machine.joints)}")
    return joint


@contextmanager
def naming_options(options: Mapping[str, str]) -> Iterator[None]:
    """Name options in place of arguments in InputErrors that are raised inside.

    An argument is named by the place of the error, or in backquotes in its text.

    Args:
        options: option of each argument, such as {"path": "--out", "meshes=False": "--no-meshes"}; an argument of a
            nested description follows the description's place, as in {"task: reach": "--reach"}.
    """
    try:
        yield
    except InputError as error:
        where = _name_place(error.where, options)
        what, right = (_name_arguments(text, options) for text in (error.what, error.right))
        if (where, what, right) == (error.where, error.what, error.right):
            raise
        raise InputError(what, where=where, right=right) from None


QUOTE_MARKS = "'\""
ARGUMENT_PATTERN = re.compile(r"`(\w+)(?:=([^`]*))?`")  # an argument in a message, perhaps with a value


def _name_place(where: str, options: Mapping[str, str]) -> str:
    """Return the place of an error with an option in place of the argument at its start."""
    for argument, option in options.items():
        following = where.removeprefix(argument) if where.startswith(argument) else None
        if following == "" or (following and following[0] in (" .:" if ": " in argument else " :")):
            return option + following
    return where


def _name_arguments(text: str, options: Mapping[str, str]) -> str:
    """Return a message with options in place of arguments in backquotes."""

    def option_of(match: re.Match[str]) -> str:
        """Return the option of a matched argument with its value, or the match itself if it is no argument."""
        name, value = match.groups()
        if match[0].strip("`") in options:
            return options[match[0].strip("`")]
        if name not in options:
            return match[0]
        return (
            options[name] if value is None else f"{options[name]} {value if ' ' in value else value.strip(QUOTE_MARKS)}"
        )

    return ARGUMENT_PATTERN.sub(option_of, text)
