"""Groups of commands that import a command's module when the command is used, and not before."""

from collections.abc import Mapping
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command, get_command_name

from layflat.outputs import FORCE

WIDTH = 100  # columns that a help may take

OUTPUTS = {"out", "png"}  # parameters that say where a command writes
ASKING = ("panel", "studio")  # commands whose pages ask before they replace a file


class LazyTyper(typer.Typer):
    """An application whose commands register themselves when their modules are imported.

    Args:
        name: as typed.
        text: of its help.
        commands: modules of `layflat.cli` by the names of the commands in them, in the order of the help;
            "module:attribute" for a group, which is an application of its own.
    """

    def __init__(self, name: str, text: str, commands: Mapping[str, str]) -> None:
        owner = self

        class LazyGroup(TyperGroup):
            def __init__(self, **settings: Any) -> None:
                super().__init__(**settings)
                self.commands = dict.fromkeys(commands)  # type: ignore[assignment]  # names, to suggest the nearest

            def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002
                return owner.built(cmd_name) if cmd_name in commands else None

        self.modules = commands
        super().__init__(
            name=name,
            help=text,
            cls=LazyGroup,
            no_args_is_help=True,
            add_completion=False,
            pretty_exceptions_enable=False,
            rich_markup_mode=None,
            context_settings={"max_content_width": WIDTH},
        )

    def built(self, name: str) -> Any:
        """Import the module of a command and build the command."""
        place, _, group = self.modules[name].partition(":")
        module = import_module(f"layflat.cli.{place}")
        if group:
            return get_command(getattr(module, group))
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.registered_commands = [
            info
            for info in self.registered_commands
            if info.callback is not None and name == (info.name or get_command_name(info.callback.__name__))
        ]
        return with_force(get_command(single)) if name not in ASKING else get_command(single)


def with_force(command: Any) -> Any:
    """Give a command that writes files the option --force, which no function needs: `layflat.outputs` reads it."""
    if OUTPUTS & {one.name for one in command.params}:
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.command()(_forced)
        option = next(one for one in get_command(single).params if one.name == "force")
        option.expose_value = False
        command.params.append(option)
    return command


def _forced(
    force: Annotated[bool, typer.Option(FORCE, help="replace files that are there, whoever wrote them")] = False,
) -> None:
    """Declare the option, as typer makes options of a function's parameters alone."""
