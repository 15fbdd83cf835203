"""Reference of the command line, from the commands themselves."""

from collections.abc import Iterator
from typing import Any

from layflat.cli import app
from layflat.cli.lazy import LazyTyper, command_examples


def command_reference() -> str:
    """Return the page of all commands: what each does, its examples, arguments and options."""
    about = "Each command with its examples, arguments and options, as `--help` prints them."
    parts = ["# Command line", "", about, ""]
    for heading, places in app.sections.items():
        parts += [f"## {heading}", ""]
        for name, place in places.items():
            if isinstance(place, LazyTyper):
                parts += [f"### layflat {name}", "", _text(place.info.help or ""), ""]
            level = "####" if isinstance(place, LazyTyper) else "###"
            for words, command in walk_commands(app.build_command(name), f"layflat {name}"):
                parts += _section(level, words, command)
    return "\n".join(parts)


def walk_commands(command: Any, words: str) -> Iterator[tuple[str, Any]]:
    """Yield a command, or the commands of a group, each with its words such as "layflat rig run"."""
    if not hasattr(command, "list_commands"):
        yield words, command
        return
    context = command.make_context(words, [], resilient_parsing=True)
    for name in command.list_commands(context):
        yield from walk_commands(command.get_command(context, name), f"{words} {name}")


def _section(level: str, words: str, command: Any) -> Iterator[str]:
    context = command.make_context(words, [], resilient_parsing=True)
    yield f"{level} {words}\n"
    yield f"{_text(command.help or '')}\n"
    lines = [" ".join([words, *command.collect_usage_pieces(context)]), "", *command_examples(command, words)]
    yield "\n".join(["```text", *lines, "```", ""])
    records = [record for parameter in command.params if (record := _record(parameter, context))]
    if records:
        yield "| | |\n|---|---|"
        yield from (f"| `{name}` | {_text(about)} |" for name, about in records)
        yield ""


def _record(parameter: Any, context: Any) -> tuple[str, str] | None:
    record = parameter.get_help_record(context)
    if record is None or "--help" in record[0]:
        return None
    return record[0].replace("|", "\\|"), " ".join(record[1].split())


def _text(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")
