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
            several = get_command(getattr(module, group))
            for command in filter(None, several.commands.values()):  # type: ignore[attr-defined]  # none of a lazy group
                refuse_unclear(command)
            return several
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.registered_commands = [
            info
            for info in self.registered_commands
            if info.callback is not None and name == (info.name or get_command_name(info.callback.__name__))
        ]
        return refuse_unclear(with_force(get_command(single)) if name not in ASKING else get_command(single))


def refuse_unclear(command: Any) -> Any:
    """Make a command refuse an option that is given twice and has one value, and one that is given empty.

    The last would win without a word, and an empty value, such as a script's variable that is not set, would be as
    none, or the folder in which the command runs.
    """
    make_parser = command.make_parser

    def made(context: Any) -> Any:
        parser = make_parser(context)
        parse = parser.parse_args

        def parsed(args: list[str]) -> Any:
            found = parse(args=args)
            seen: set[str] = set()
            for parameter in found[2]:
                single = parameter.param_type_name == "option" and not (parameter.multiple or parameter.is_flag)
                if single and parameter.name in seen:
                    raise typer.BadParameter("is given twice; give it once", ctx=context, param=parameter)
                given = found[0].get(parameter.name)
                if parameter.param_type_name == "option" and "" in (given if parameter.multiple else [given]):
                    right = "is empty; leave it out, or give a value"
                    raise typer.BadParameter(right, ctx=context, param=parameter)
                seen.add(parameter.name)
            return found

        parser.parse_args = parsed
        return parser

    command.make_parser = made
    return command


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
