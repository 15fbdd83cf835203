"""Pages say what is true: their commands can be typed as they stand, their links lead somewhere."""

import os
import pkgutil
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import typer.main

from layflat.cli import app
from layflat.cli.lazy import LazyTyper
from tests.docs.blocks import PAGES, ROOT, TUTORIALS, commands, read_blocks, words_of

GROUPS = {name for name, place in app.places.items() if isinstance(place, LazyTyper)}
SOURCES = re.compile(r"\(((?:[a-z]+\d{4}[a-z]?)(?:, [a-z]+\d{4}[a-z]?)*)\)")  # keys of docs/references.bib


def parsed(words: list[str]) -> Any:
    """The context of a command, which raises where a word or an option is unknown."""
    command: Any = typer.main.get_command(app)
    context = command.make_context("layflat", words[1:])
    while hasattr(command, "list_commands") and (rest := [*context._protected_args, *context.args]):
        name, command, rest = command.resolve_command(context, rest)
        context = command.make_context(name, rest, parent=context)
    return context


ALL = [
    pytest.param(line, id=f"{page.stem}: {line[:60]}")
    for page in PAGES for block in read_blocks(page) for _, line in commands(block)
]  # fmt: skip


def test_there_are_commands() -> None:
    assert len(ALL) > 25


@pytest.mark.parametrize("line", ALL)
def test_commands_can_be_typed(line: str) -> None:
    with suppress(typer.Exit):  # --version ends early
        parsed(words_of(line)[0])


def test_an_unknown_option_would_be_found() -> None:
    with pytest.raises(typer.TyperException, match="No such option"):
        parsed(["layflat", "rig", "run", "paper-arm", "--no-such-option"])


def test_commands_in_tables_are_there() -> None:
    names = GROUPS | app.places.keys() | {f"{group} {name}" for group in GROUPS for name in app.places[group].places}  # type: ignore[union-attr]
    for page in PAGES:
        for name in re.findall(rf"`layflat ((?:{'|'.join(GROUPS)}) [a-z]+|[a-z]+)", page.read_text(encoding="utf-8")):
            assert name in names, f"{page.name}: layflat {name}"


def test_a_tutorials_first_command_works_in_a_shell(tmp_path: Path) -> None:
    script = tmp_path / "bin" / "layflat"
    script.parent.mkdir()
    script.write_text(f"#!{sys.executable}\nfrom layflat.cli import main\nmain()\n", encoding="utf-8")
    script.chmod(0o755)
    environment = os.environ | {"PATH": f"{script.parent}:{os.environ['PATH']}", "MPLBACKEND": "agg"}
    first = next(line for block in read_blocks(TUTORIALS[0]) for _, line in commands(block))
    done = subprocess.run(
        ["/bin/sh", "-c", first], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8")):
        if not link.startswith(("http", "mailto")):
            assert (page.parent / link).exists(), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_files_and_names_of_the_code_are_there(page: Path) -> None:
    """What stands as `room/file.py`, and as `layflat.room.name`."""
    text = page.read_text(encoding="utf-8")
    for file in re.findall(r"`((?:\w+/)+\w+\.(?:py|toml))`", text):
        assert file.startswith("build/") or (ROOT / file).exists() or (ROOT / "src/layflat" / file).exists(), file
    for name in re.findall(r"`(layflat(?:\.[A-Za-z_]\w*)+)`", text):
        pkgutil.resolve_name(name)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_row_stands_in_its_table(page: Path) -> None:
    """A row that a blank line parts from its table is shown as text."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    begun = re.findall(r"(?:\A|\n\n)(\|[^\n]*)\n?([^\n]*)", text)
    assert [row for row, below in begun if not re.fullmatch(r"\|(?:\s*:?-+:?\s*\|)+", below)] == []


def test_the_index_names_every_page() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    missing = [page.name for page in PAGES if page.parts[-2] in {"docs", "tutorials"} and page.name not in index]
    assert missing == ["index.md"]


def test_every_source_that_is_named_is_listed() -> None:
    listed = set(re.findall(r"^@\w+{(\w+),", (ROOT / "docs" / "references.bib").read_text(), re.MULTILINE))
    named = {key for text in _texts() for found in SOURCES.findall(text) for key in found.split(", ")}
    assert named
    assert named <= listed


def _texts() -> Iterator[str]:
    for path in (*PAGES, *sorted((ROOT / "src").rglob("*.py"))):
        yield path.read_text()
