"""Lines of C: indented, broken at 120 columns, without those that compute a value that nobody reads."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

MAX_COLUMNS = 120
INDENT_TEXT = "    "
BREAK_PATTERN = re.compile(r", (?=\S)| (?=(?:[-+*/?:<>]|&&|\|\||==|<=|>=) )|(?<== )(?=[^{])")


@dataclass(frozen=True)
class Line:
    """Line of C."""

    text: str
    depth: int
    about: str = ""  # the variable for which alone the line is there
    comment: bool = False


def read_names(text: str) -> set[str]:
    """Return the names of variables and functions in an expression, without those of fields."""
    return set(re.findall(r"(?<![\w.>])[A-Za-z_]\w*", text.replace("->", ">")))


def without_unread(lines: Iterable[Line]) -> list[Line]:
    """Return lines without those that are there for a variable that no other line names."""
    kept = list(lines)
    while True:
        read = {name for line in kept if not line.comment for name in read_names(line.text) - {line.about}}
        rest = [line for line in kept if not line.about or line.about in read]
        if len(rest) == len(kept):
            return kept
        kept = rest


def render(lines: Iterable[Line]) -> Iterator[str]:
    """Yield the lines of C, broken where they are too long."""
    for line in lines:
        yield from (
            block_comment(line.text, INDENT_TEXT * line.depth)
            if line.comment
            else broken(INDENT_TEXT * line.depth + line.text, INDENT_TEXT * (line.depth + 1))
        )


def broken(text: str, indent: str) -> Iterator[str]:
    """Yield a line broken at the outermost operators and commas.

    Args:
        text: the line.
        indent: of the lines after the first.
    """
    while len(text) > MAX_COLUMNS:
        places = [
            (*_rank(text, match), match)
            for match in BREAK_PATTERN.finditer(text)
            if len(indent) < match.start() + 1 <= MAX_COLUMNS
        ]
        if not places:
            break
        match = min(places, key=lambda place: place[:3])[3]
        yield text[: match.end()].rstrip()
        text = indent + text[match.end() :]
    yield text


def _rank(text: str, match: re.Match[str]) -> tuple[int, bool, int]:
    """Return the rank of a place to break a line: outer ones first, commas before operators, then the last."""
    depth = _depth(text[: match.start()])
    return depth, depth > 0 and not match[0].startswith(","), -match.end()


def _depth(text: str) -> int:
    return sum(text.count(sign) for sign in "([{") - sum(text.count(sign) for sign in ")]}")


def block_comment(text: str, indent: str = "") -> Iterator[str]:
    """Yield a comment of C, its paragraphs filled anew; lines of tables and indented ones stay.

    Args:
        text: the comment; empty lines part paragraphs.
        indent: before each line.
    """
    columns = MAX_COLUMNS - len(indent) - len("/*  */")
    lines = [one for line in _paragraphs(text.replace("*/", "* /")) for one in _filled(line, columns)]
    yield from (f"{indent}{'/*' if i == 0 else '  '} {line}".rstrip() for i, line in enumerate(lines[:-1]))
    last = f"{indent}{'/*' if len(lines) == 1 else '  '} {lines[-1]}"
    if "" in lines:
        yield from (last, f"{indent}*/")
    else:
        yield f"{last} */"


def _paragraphs(text: str) -> Iterator[str]:
    """Yield paragraphs, each in one line, and lines that stay as they are."""
    waiting: list[str] = []
    for line in text.split("\n"):
        stays = not line.strip() or line.startswith((" ", "|", "- ")) or re.match(r"\d+\. ", line)
        if stays and waiting:
            yield " ".join(waiting)
            waiting.clear()
        if stays:
            yield line.rstrip()
        else:
            waiting.append(line.strip())
    if waiting:
        yield " ".join(waiting)


def _filled(line: str, columns: int) -> Iterator[str]:
    space = len(line) - len(line.lstrip())
    while len(line) > columns:
        at = line.rfind(" ", space + 1, columns + 1)
        if at < 0:
            break
        yield line[:at].rstrip()
        line = " " * max(space, 4 if line.startswith("|") else 0) + line[at + 1 :]
    yield line
