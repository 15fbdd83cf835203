"""Pages say what is true: their commands can be typed as they stand, their links lead somewhere."""

import os
import pkgutil
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import typer.main

from layflat.cli import app
from tests.cli.commands import layflat

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TUTORIALS = [page for page in PAGES if page.parent.name == "tutorials"]

CHEAP = {
    "machines",
    "show",
    "check",
    "schema",
    "design",
    "size",
    "loop",
    "simulate",
    "studies",
    "cells",
    "arm-model",
    "excite",
    "identify",
}
"""Commands that are run where a tutorial has them; the others are parsed only."""

SOURCES = re.compile(r"\(((?:[a-z]+\d{4}[a-z]?)(?:, [a-z]+\d{4}[a-z]?)*)\)")  # keys of docs/references.bib
PUNCTUATION = {"<", ">", "&", "2>", ">>"}


def blocks(page: Path, kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)


def commands(page: Path) -> Iterator[str]:
    """Lines of a page's shell blocks that call layflat."""
    for block in blocks(page, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            if line.strip().startswith("layflat "):
                yield line.strip()


def words_of(line: str) -> list[str]:
    """A command's words, without comment and redirections."""
    words = shlex.split(line, comments=True)
    ends = [i for i, word in enumerate(words) if word in PUNCTUATION]
    return words[: ends[0]] if ends else words


def parsed(words: list[str]) -> Any:
    """The context of a command, which raises where a word or an option is unknown."""
    command: Any = typer.main.get_command(app)
    context = command.make_context("layflat", words[1:])
    while hasattr(command, "list_commands") and (rest := [*context._protected_args, *context.args]):
        name, command, rest = command.resolve_command(context, rest)
        context = command.make_context(name, rest, parent=context)
    return context


def rows_of(text: str) -> list[list[str]]:
    """Rows of the tables that a command prints, cell by cell."""
    return [[cell.strip() for cell in re.split("[┃│]", line)] for line in text.splitlines() if re.search("[┃│]", line)]


def is_shown_as(cells: list[str], shown: list[str]) -> bool:
    """Return whether a page may show a row so: "..." stands for any cell."""
    return len(cells) == len(shown) and all(b in {a, "..."} for a, b in zip(cells, shown, strict=True))


def printed_rows(page: Path, line: str) -> list[list[str]]:
    """Rows of the table that a page shows behind a block whose last command this is."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for (_, block), (kind, shown) in pairwise(fenced):
        if kind == "" and block.strip().endswith(line):
            return rows_of(shown)
    return []


ALL = [pytest.param(line, id=f"{page.stem}: {line[:60]}") for page in PAGES for line in commands(page)]


def test_there_are_commands() -> None:
    assert len(ALL) > 25


@pytest.mark.parametrize("line", ALL)
def test_commands_can_be_typed(line: str) -> None:
    with suppress(typer.Exit):  # --version ends early
        parsed(words_of(line))


def test_an_unknown_option_would_be_found() -> None:
    with pytest.raises(typer.TyperException, match="No such option"):
        parsed(["layflat", "rig", "run", "paper-arm", "--no-such-option"])


def test_commands_in_tables_are_there() -> None:
    known = typer.main.get_command(app)
    for page in PAGES:
        for name in re.findall(r"`layflat ([a-z][a-z-]*)", page.read_text(encoding="utf-8")):
            assert name in known.commands, f"{page.name}: layflat {name}"  # type: ignore[attr-defined]


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_works_as_typed(page: Path, tmp_path: Path) -> None:
    """In a fresh folder, with the files that it tells to write; without what takes long, and what builds on that."""
    text = page.read_text(encoding="utf-8")
    names = re.findall(r"`([\w-]+\.toml)`[^`]*:\n\n```toml", text)
    for name, block in zip(names, blocks(page, "toml"), strict=True):
        (tmp_path / name).write_text(block, encoding="utf-8")
    left_out: list[str] = []
    for line in commands(page):
        words = words_of(line)
        if words[1] not in CHEAP or any("tuned" in word for word in words):
            left_out.append(words[1])
            continue
        done = layflat(*words[1:], cwd=tmp_path)
        assert done.returncode == 0, f"{line}\n{done.stderr}"
        printed = rows_of(done.stdout)
        for row in printed_rows(page, line):
            assert any(is_shown_as(cells, row) for cells in printed), f"{line} prints no row {row}"
        _, _, into = " ".join(shlex.split(line, comments=True)).partition(" > ")
        if into:
            (tmp_path / into).write_text(done.stdout, encoding="utf-8")
    assert set(left_out) <= {"tune", "pack", "simulate"}


def test_a_tutorials_first_command_works_in_a_shell(tmp_path: Path) -> None:
    script = tmp_path / "bin" / "layflat"
    script.parent.mkdir()
    script.write_text(f"#!{sys.executable}\nfrom layflat.cli import main\nmain()\n", encoding="utf-8")
    script.chmod(0o755)
    environment = os.environ | {"PATH": f"{script.parent}:{os.environ['PATH']}", "MPLBACKEND": "agg"}
    first = next(line for line in commands(TUTORIALS[0]) if words_of(line)[1] in CHEAP)
    done = subprocess.run(
        ["/bin/sh", "-c", first], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_the_readmes_ten_lines_give_numbers_and_a_picture(tmp_path: Path) -> None:
    (code,) = blocks(ROOT / "README.md", "python")
    environment = os.environ | {"MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert re.fullmatch(r"large: settled in .* s\nair: .* normal litres\n", done.stdout)
    assert [path.name for path in tmp_path.iterdir()] == ["angles.png"]


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
