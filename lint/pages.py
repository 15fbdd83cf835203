"""Check of the pages: words that the glossary replaces, headings and sentences that begin wrongly."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from lint.findings import Finding, Words

HIDDEN = re.compile(r"^```.*?^```|`[^`]*`|<!--.*?-->|\]\([^)]*\)|https?://\S+", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#+ +(\w+)(?!-)", re.MULTILINE)
OPENING = re.compile(r"\A#[^\n]*\n+(\w+)(?!-)")
FRAGMENT = re.compile(r"(?:^(?:[-|] +)?|[.!?:]\s+)(Of\s(?:[^.!?,|\n]|\n(?!\n))*[.!?])(?=\s|$)", re.MULTILINE)


def check_page(path: Path, text: str, words: Words) -> Iterator[Finding]:
    """Yield the findings of a page in Markdown, outside its code, comments and links."""
    prose = HIDDEN.sub(lambda match: re.sub(r"\S", "\0", match[0]), text)
    for at, rule, finding in sorted([*_headings(prose, words), *_fragments(prose), *_page_phrases(prose, words)]):
        yield Finding(path, text.count("\n", 0, at) + 1, rule, finding)


def find_phrases(text: str, phrases: Mapping[str, str]) -> Iterator[tuple[int, str, str]]:
    """Yield the phrases that a text has as whole words, in any case: position, text there, and what to use instead."""
    for phrase, right in phrases.items():
        pattern = phrase.replace(" ", r"\s+")
        for match in re.finditer(rf"\b(?:{pattern})\b", text, re.IGNORECASE):
            yield match.start(), " ".join(match[0].split()), right


def _page_phrases(prose: str, words: Words) -> Iterator[tuple[int, str, str]]:
    """Yield position, rule and text of a finding for each phrase that pages do without."""
    for at, phrase, right in find_phrases(prose, words.phrases | words.page_phrases):
        yield at, "page", f"{phrase!r}; use {right}"


def _headings(prose: str, words: Words) -> Iterator[tuple[int, str, str]]:
    """Yield position, rule and text of findings: headings, and the page's first sentence, that begin wrongly."""
    for pattern, rule in ((HEADING, "heading"), (OPENING, "first sentence")):
        for match in pattern.finditer(prose):
            if match[1].lower() in words.first:
                yield match.start(1), rule, f"begins with {match[1]!r}; say what the reader gets"


def _fragments(prose: str) -> Iterator[tuple[int, str, str]]:
    """Yield position, rule and text of a finding for each sentence that begins with "Of"."""
    for match in FRAGMENT.finditer(prose):
        yield match.start(1), "sentence", f"{' '.join(match[1].split())!r} begins with 'Of'; put subject and verb first"
