"""Positions of keys and texts in a TOML or JSON file, so that names can be replaced while all else stays as it is.

The scanner takes files that a parser has accepted; it checks nothing.
"""

import re
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field

from layflat.description.renamed import Steps

_TOKEN_PATTERN = re.compile(
    r"""
    (?P<blank> [ \t\r\ufeff]+ | \#[^\n]*) | (?P<line> \n)
    | (?P<text> \"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5} | \"(?:\\.|[^\"\\\n])*\" | '[^'\n]*')
    | (?P<mark> [\[\]{},.=:]) | (?P<bare> [^\s\[\]{},.=:\#\"']+)
    """,
    re.VERBOSE | re.DOTALL,
)
_BARE_KEY_PATTERN = re.compile(r"[A-Za-z0-9_-]+")
_VALUE_ENDS = ("", "line", ",", "]", "}")


@dataclass(frozen=True)
class NameToken:
    """Key of a file, or a text that is a value, with its quotes."""

    steps: Steps  # of the key, or of the value
    start: int  # position of its first character
    end: int  # position behind its last character
    is_key: bool

    @property
    def is_name(self) -> bool:
        """True if it may name a key: as a key, or as an item of a list of paths."""
        return self.is_key or isinstance(self.steps[-1], int)


@dataclass
class _Scanner:
    """Scanner of the text of a file, at the position `at` in its tokens."""

    text: str
    tokens: list[tuple[str, int, int]] = field(init=False)  # kind, start and end
    at: int = 0
    items: dict[Steps, int] = field(default_factory=dict)  # index of the last table of each array of tables

    def __post_init__(self) -> None:
        """Split the text into tokens, without blanks and comments."""
        matches = ((match.lastgroup or "", *match.span()) for match in _TOKEN_PATTERN.finditer(self.text))
        self.tokens = [token for token in matches if token[0] != "blank"]

    @property
    def next(self) -> str:
        """Next token: a mark itself, else "text", "bare" or "line"; "" at the end."""
        if self.at >= len(self.tokens):
            return ""
        kind, start, end = self.tokens[self.at]
        return self.text[start:end] if kind == "mark" else kind

    def skip(self, *tokens: str) -> None:
        """Advance past any number of these tokens, in any order."""
        while self.next in tokens:
            self.at += 1

    def tables(self) -> Iterator[NameToken]:
        """Yield the keys and text values of a TOML file, in their order."""
        table: Steps = ()
        self.skip("line")
        while self.next:
            if self.next == "[":
                self.at += 1
                is_array = self.next == "["
                self.skip("[")
                table = yield from self.key(())
                if is_array:
                    self.items[table] = self.items.get(table, -1) + 1
                    table = (*table, self.items[table])
                self.skip("]")
            else:
                yield from self.pair(table)
            self.skip("line")

    def key(self, steps: Steps) -> Generator[NameToken, None, Steps]:
        """Yield the parts of a dotted key, and return its steps: those of its table, the `steps` given, and its own."""
        while self.next in {"bare", "text"}:
            _, start, end = self.tokens[self.at]
            name = self.text[start:end]
            steps = (*steps, name[1:-1] if name[0] in "\"'" else name)
            yield NameToken(steps, start, end, True)
            self.at += 1
            if self.next == "." and steps in self.items:
                steps = (*steps, self.items[steps])
            self.skip(".")
        return steps

    def pair(self, table: Steps) -> Iterator[NameToken]:
        """Yield the keys and text values of a key, in the table at these steps, with its value."""
        steps = yield from self.key(table)
        self.skip("=", ":", "line")
        yield from self.value(steps)

    def value(self, steps: Steps) -> Iterator[NameToken]:
        """Yield the keys and text values within the value at these steps."""
        if self.next in {"[", "{"}:
            is_list = self.next == "["
            closing, item = "]" if is_list else "}", 0
            self.at += 1
            self.skip("line")
            while self.next not in {closing, ""}:
                yield from self.value((*steps, item)) if is_list else self.pair(steps)
                item += 1
                self.skip(",", "line")
            self.at += 1
            return
        kind, start, end = self.tokens[self.at]
        if kind == "text":
            yield NameToken(steps, start, end, False)
        while self.next not in _VALUE_ENDS:
            self.at += 1


def names_in(text: str, *, json: bool = False) -> list[NameToken]:
    """Return the keys and text values of a TOML file, with `json` of a JSON file, in their order."""
    scanner = _Scanner(text)
    if json:
        scanner.skip("line")
        return list(scanner.value(()))
    return list(scanner.tables())


def replace_names(text: str, names: dict[NameToken, str]) -> str:
    """Return a text with names replaced; quotes stay as they are, and are added to a name that needs them.

    Args:
        text: of the file.
        names: new name of each token.
    """
    parts, at = [], 0
    for token in sorted(names, key=lambda one: one.start):
        quote = text[token.start] if text[token.start] in "\"'" else ""
        name = names[token]
        if not quote and not _BARE_KEY_PATTERN.fullmatch(name):
            quote = '"'
        parts += [text[at : token.start], quote, name, quote]
        at = token.end
    return "".join([*parts, text[at:]])
