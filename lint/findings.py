"""Findings of the language check, and the words that its rules name."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

WORDS = Path(__file__).with_name("words.toml")


class Finding(NamedTuple):
    """Place that breaks a rule."""

    path: Path
    line: int
    rule: str
    text: str

    def __str__(self) -> str:
        """Return the line that is printed."""
        return f"{self.path}:{self.line}: {self.rule}: {self.text}"


@dataclass(frozen=True)
class Words:
    """Words that the rules name.

    Attributes:
        first: words that no docstring and no heading begins with.
        functions: names that say nothing of what a function computes.
        parameters: names that say nothing of what a parameter is.
        constants: single words that are terms of the field, and so may be a constant's whole name.
        classes: names that several kinds define by contract.
        phrases: words that messages and pages do without, and what they use instead.
        page_phrases: further ones that pages do without.
        pending: paths of rooms and pages that are not checked yet.
    """

    first: frozenset[str]
    functions: frozenset[str]
    parameters: frozenset[str]
    constants: frozenset[str]
    classes: frozenset[str]
    phrases: dict[str, str]
    page_phrases: dict[str, str]
    pending: tuple[str, ...]

    @classmethod
    def read(cls, path: Path = WORDS) -> "Words":
        """Return the words in a TOML file with a key for each attribute."""
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        sets = {key: frozenset(table[key]) for key in ("first", "functions", "parameters", "constants", "classes")}
        phrases, page_phrases = table["phrases"], table["page_phrases"]
        return cls(**sets, phrases=phrases, page_phrases=page_phrases, pending=tuple(table["pending"]))
