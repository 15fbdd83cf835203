"""Help of the command line: commands under headings, one sentence each, with examples that can be typed."""

import shlex
from typing import Any

import pytest
import typer.main

from docs.site.commands import walk_commands
from layflat.cli import app
from layflat.cli.lazy import LazyTyper, command_examples
from tests.cli.commands import layflat

COMMANDS = dict(walk_commands(typer.main.get_command(app), "layflat"))
GROUPS = ["", *(name for name, place in app.places.items() if isinstance(place, LazyTyper))]
EXAMPLES = [line for words, command in COMMANDS.items() for line in command_examples(command, words)]
COLUMNS = 80  # of a usual terminal


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(COLUMNS))


def test_commands_stand_under_headings() -> None:
    lines = layflat("--help").stdout.splitlines()
    headings = [line.removesuffix(":") for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert headings == ["Options", *app.sections]


@pytest.mark.usefixtures("narrow")
@pytest.mark.parametrize("group", GROUPS)
def test_each_command_has_a_line_that_is_a_sentence(group: str) -> None:
    words = group.split()
    place = app.places[group] if group else app
    assert isinstance(place, LazyTyper)
    lines = layflat(*words, "--help").stdout.splitlines()
    for name in place.places:
        (line,) = (line for line in lines if line.startswith(f"  {name} "))
        assert len(line) <= COLUMNS, line
        assert line.endswith("."), line
        assert "..." not in line, line


@pytest.mark.usefixtures("narrow")
@pytest.mark.parametrize("words", COMMANDS)
def test_each_command_shows_one_to_three_examples(words: str) -> None:
    shown = layflat(*words.split()[1:], "--help").stdout
    examples = command_examples(COMMANDS[words], words)
    assert 1 <= len(examples) <= 3
    assert shown.endswith("\nExamples:\n" + "".join(f"  {line}\n" for line in examples))
    assert max(map(len, examples)) <= COLUMNS - 2


@pytest.mark.parametrize("line", EXAMPLES)
def test_an_example_can_be_typed(line: str) -> None:
    words, _, _ = line.partition(" > ")
    command: Any = typer.main.get_command(app)
    context = command.make_context("layflat", shlex.split(words)[1:])
    while hasattr(command, "list_commands"):
        name, command, rest = command.resolve_command(context, [*context._protected_args, *context.args])
        context = command.make_context(name, rest, parent=context)
    assert context.args == []
