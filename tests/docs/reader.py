"""A reader who types the blocks of a page, from top to bottom, in a fresh folder."""

import contextlib
import io
import traceback
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from layflat.errors import LayflatError
from tests.cli.commands import layflat
from tests.docs.blocks import Block, commands, words_of
from tests.docs.comparing import find_difference

NOT_RUN = {
    "layflat export": "compiles for half a minute",
    "layflat docs": "shows pages until its reader is through",
    "layflat motion learn": "takes half a minute or more",
    "layflat cell pack": "takes a minute or more",
    "layflat foxglove": "serves until Ctrl-C",
    "layflat panel": "serves until Ctrl-C",
    "layflat reproduce": "takes minutes",
    "layflat rig": "moves in real time",
    "layflat arm size": "takes a minute or more",
    "layflat studio": "serves until Ctrl-C",
    "layflat tune": "takes a minute or more",
    "layflat arm view": "serves until Ctrl-C",
}
"""Beginnings of commands that are parsed only, each with its reason."""


class PageError(AssertionError):
    """Block of a page that does not do what the page says: its message begins with page and line."""


class Reader:
    """Reader of one page.

    Attributes:
        folder: folder in which the reader writes files and types commands.
        names: names that the page's Python has defined so far.
        printed: output of the last block of code; None if it was not run.
        missing: whether a command was left out, whose results later ones may need.
    """

    def __init__(self, folder: Path, names: dict[str, Any] | None = None) -> None:
        self.folder = folder
        self.names: dict[str, Any] = {"__name__": "__page__"} | (names or {})
        self.printed: str | None = None
        self.missing = False

    def read(self, block: Block) -> None:
        """Write, run or compare a block.

        Raises:
            PageError: it fails, or prints something else than the page shows.
        """
        if block.name:
            (self.folder / block.name).write_text(block.text, encoding="utf-8")
        elif block.is_code:
            self.printed = None
            if block.reason:
                self.missing = True
                return
            with contextlib.chdir(self.folder):
                self.printed = self._run_python(block) if block.language == "python" else self._run_commands(block)
        elif block.language == "output" and not block.reason:
            self._compare(block)

    def _run_python(self, block: Block) -> str:
        out = io.StringIO()
        code = compile("\n" * block.line + block.text, str(block.page), "exec")  # with the page's numbers of lines
        try:
            with contextlib.redirect_stdout(out):
                exec(code, self.names)
        except Exception as error:
            lines = [frame.lineno or 0 for frame in traceback.extract_tb(error.__traceback__)]
            files = [frame.filename for frame in traceback.extract_tb(error.__traceback__)]
            line = max((n for n, file in zip(lines, files, strict=True) if file == str(block.page)), default=block.line)
            raise PageError(f"{block.place(line - block.line)}: {type(error).__name__}: {error}") from error
        return out.getvalue()

    def _run_commands(self, block: Block) -> str | None:
        printed = []
        for number, command in commands(block):
            words, target = words_of(command)
            if command.startswith(tuple(NOT_RUN)) or (self.missing and not self._files_exist(words)):
                self.missing = True
                continue
            result = layflat(*words[1:])
            if result.returncode:
                raise PageError(f"{block.place(number)}: `{command}`: {result.stderr.strip()}")
            if target:
                Path(target).write_text(result.stdout, encoding="utf-8")
            printed.append(result.stdout)
        return "".join(printed) if printed else None

    def _files_exist(self, words: list[str]) -> bool:
        """Return whether all files are there that a command reads."""
        inputs = [word for option, word in pairwise(words) if option not in {"-o", "--out"}]
        return all((self.folder / word).exists() for word in inputs if word.endswith((".toml", ".nc", ".csv", ".mcap")))

    def _compare(self, block: Block) -> None:
        if self.printed is None:
            raise PageError(f"{block.place()}: no code that is run stands before this output")
        difference = find_difference(block.text, self.printed)
        if difference:
            line, text = difference
            raise PageError(f"{block.place(line)}: {text}")


def check_descriptions(blocks: list[Block], folder: Path) -> Iterator[str]:
    """Yield what is wrong with the complete descriptions of machines and cells on a page, which `folder` holds."""
    import tomllib

    from layflat.cell import load as load_cell
    from layflat.machine import load, names

    for block in blocks:
        if block.language != "toml" or block.reason:
            continue
        try:
            table = tomllib.loads(block.text)
            if block.name and "extends" in table:
                base = table["extends"]
                is_machine = base in names() or base.endswith(".toml")
                (load if is_machine else load_cell)(folder / block.name)
        except (LayflatError, tomllib.TOMLDecodeError) as error:
            yield f"{block.place()}: {error}"
