"""Groups of commands that import a command's module when the command is used, and not before."""

import gc
from collections.abc import Callable, Mapping
from importlib import import_module
from inspect import cleandoc
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from layflat.outputs import FORCE

WIDTH = 100  # columns that a help may take

OUTPUT_PARAMETERS = {"out", "png"}  # parameters with a command's output path
PAGE_COMMANDS = ("panel", "studio")  # commands whose pages ask before they replace a file


class LazyTyper(typer.Typer):
    """Application whose commands register themselves when their modules are imported.

    Args:
        name: name of the application or group.
        text: its help text.
        sections: headings of its help; below each the commands, with the module of `layflat.cli` that each is in, or
            the group that each is.
    """

    def __init__(self, name: str, text: str, sections: Mapping[str, Mapping[str, "str | LazyTyper"]]) -> None:
        """Make the application with its help; modules are imported once their commands are used."""
        owner = self

        class LazyGroup(TyperGroup):
            def __init__(self, **settings: Any) -> None:
                super().__init__(**settings)
                self.commands = dict.fromkeys(owner.places)  # type: ignore[assignment]  # names, to suggest the nearest

            def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002
                return owner.build_command(cmd_name) if cmd_name in owner.places else None

            def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002
                """Write the short help of all commands and groups, below their headings."""
                width = max(map(len, owner.places))
                for heading, names in sections.items():
                    with formatter.section(heading):
                        formatter.write_dl([(name.ljust(width), owner.short_help(name)) for name in names])

        self.sections = sections
        self.places = {name: place for names in sections.values() for name, place in names.items()}
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
        self.callback()(_without_options)  # a group is one also where a single command of it is known yet

    def register(self, name: str, *examples: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Return a decorator that makes a function a command of this group.

        Args:
            name: name of the command.
            examples: command lines that its help shows, without the words up to its name.
        """
        return self.command(name, cls=CheckedCommand, epilog="\n".join(examples))

    def short_help(self, name: str) -> str:
        """Return the help line of a command, whose module is imported, or group; its slow options are not built."""
        place = self.places[name]
        if isinstance(place, LazyTyper):
            return _first_sentence(str(place.info.help))
        import_module(f"layflat.cli.{place}")
        (command,) = (info for info in self.registered_commands if info.name == name)
        return _first_sentence(str(command.help or getattr(command.callback, "__doc__", "")))

    def build_command(self, name: str) -> Any:
        """Import a command's module and return the command, with --force where it writes; or return a group."""
        place = self.places[name]
        if isinstance(place, LazyTyper):
            return _with_short_help(get_command(place))
        import_module(f"layflat.cli.{place}")
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.registered_commands = [info for info in self.registered_commands if info.name == name]
        command = _with_short_help(get_command(single))
        return command if name in PAGE_COMMANDS else _with_force(command)


class CheckedCommand(TyperCommand):
    """Command that refuses options which are given twice or empty, and shows examples in its help.

    Otherwise the last value would win silently, and an empty one, such as a script's unset variable, would count as
    none, or as the folder in which the command runs.
    """

    def invoke(self, ctx: Any) -> Any:
        """Enable the collection of garbage, from which what was imported until now is exempt, and run the command."""
        gc.freeze()
        gc.enable()
        return super().invoke(ctx)

    def make_parser(self, ctx: Any) -> Any:
        """Return the parser of the arguments; it raises BadParameter for an option given twice, or empty."""
        parser: Any = super().make_parser(ctx)
        parse = parser.parse_args

        def parse_checked(args: list[str]) -> Any:
            """Parse arguments; raise BadParameter for an option that is given twice or empty."""
            result = parse(args=args)
            seen: set[str] = set()
            for parameter in result[2]:
                single = parameter.param_type_name == "option" and not (parameter.multiple or parameter.is_flag)
                if single and parameter.name in seen:
                    raise typer.BadParameter("is given twice; give it once", ctx=ctx, param=parameter)
                value = result[0].get(parameter.name)
                if parameter.param_type_name == "option" and "" in (value if parameter.multiple else [value]):
                    right = "is empty; leave it out, or give a value"
                    raise typer.BadParameter(right, ctx=ctx, param=parameter)
                seen.add(parameter.name)
            return result

        parser.parse_args = parse_checked
        return parser

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the examples, each as it is typed."""
        with formatter.section("Examples"):
            for line in command_examples(self, ctx.command_path):
                formatter.write(f"{'':{formatter.current_indent}}{line}\n")


def command_examples(command: Any, path: str) -> list[str]:
    """Return the examples of a command as they are typed.

    Args:
        command: command of a `LazyTyper`.
        path: words up to its name, such as "layflat machine show".
    """
    return [f"{path} {words}".strip() for words in command.epilog.split("\n")]


def _with_short_help(command: Any) -> Any:
    """Set the help line of a command in the list of its group, the whole first sentence of its help; return it."""
    command.short_help = _first_sentence(command.help)
    return command


def _first_sentence(text: str) -> str:
    first = " ".join(cleandoc(text).partition("\n\n")[0].split())
    return first.partition(". ")[0].removesuffix(".") + "."


def _with_force(command: Any) -> Any:
    """Add the option --force to a command with an output path, and return the command.

    `layflat.outputs` reads the option, and no function receives it.
    """
    if OUTPUT_PARAMETERS & {one.name for one in command.params}:
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.command()(_forced)
        option = next(one for one in get_command(single).params if one.name == "force")
        option.expose_value = False
        command.params.append(option)
    return command


def _forced(
    force: Annotated[bool, typer.Option(FORCE, help="replace files that are there, whoever wrote them")] = False,
) -> None:
    """Declare the option --force: typer makes options only of a function's parameters."""


def _without_options() -> None:
    """Accept no option before the commands of a group."""
