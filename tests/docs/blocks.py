"""Blocks of code and of printed output on the pages, in the order in which a reader meets them."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TUTORIALS = [page for page in PAGES if page.parent.name == "tutorials"]

FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
EXCEPTION = re.compile(r"<!--\s*(not run|not compared):\s*(.+?)\s*-->\s*\Z", re.DOTALL)
NAME = r"[\w-]+\.(?:toml|py)"
NAME_INSIDE = re.compile(rf"# ({NAME})\b")  # first line of the block
NAME_BEFORE = re.compile(rf"`({NAME})`[^`]*:\s*\Z")  # end of the text before the block
PUNCTUATION = {"<", ">", "&", "2>", ">>"}


@dataclass(frozen=True)
class Block:
    """Fenced block of a page.

    Attributes:
        page: file of the page.
        line: number of the line of the opening fence.
        language: word behind the opening fence, such as `python` or `output`.
        text: lines between the fences.
        name: file that a reader writes the block to; "" if there is none.
        reason: why the block is not run, or not compared, as a comment before the block says; "" without a comment.
    """

    page: Path
    line: int
    language: str
    text: str
    name: str = ""
    reason: str = ""

    @property
    def is_code(self) -> bool:
        """Return whether the block can be run."""
        return self.language in {"python", "sh"}

    def place(self, line: int = 0) -> str:
        """Return page and line, as messages name them, of a line of the block that is counted from 1."""
        page = self.page.relative_to(ROOT) if self.page.is_relative_to(ROOT) else self.page
        return f"{page}:{self.line + line}"


def read_blocks(page: Path) -> list[Block]:
    """Return the blocks of a page from top to bottom."""
    text, blocks = page.read_text(encoding="utf-8"), []
    for fence in FENCE.finditer(text):
        before = text[: fence.start()]
        reason = EXCEPTION.search(before)
        name = NAME_INSIDE.match(fence[2]) or NAME_BEFORE.search(before)
        blocks.append(
            Block(
                page,
                before.count("\n") + 1,
                fence[1].strip(),
                fence[2],
                name[1] if name else "",
                reason[2] if reason else "",
            )
        )
    return blocks


def commands(block: Block) -> Iterator[tuple[int, str]]:
    """Yield the calls of layflat in a block of a shell, each with its line in the block, counted from 1."""
    start = 0
    parts: list[str] = []
    for number, line in enumerate(block.text.splitlines(), start=1):
        start = start if parts else number
        parts.append(line.removesuffix("\\").strip())
        if not line.endswith("\\"):
            if parts[0].startswith("layflat "):
                yield start, " ".join(parts)
            parts = []


def words_of(command: str) -> tuple[list[str], str]:
    """Return the words of a command without comment and redirection, and the file that its output goes to, or ""."""
    words = shlex.split(command, comments=True)
    ends = [i for i, word in enumerate(words) if word in PUNCTUATION]
    if not ends:
        return words, ""
    return words[: ends[0]], words[ends[0] + 1] if words[ends[0]] == ">" else ""
