"""Comparison of the output on a page with what a block really prints: words exactly, numbers by tolerance.

On a page, "..." stands for anything in its line, and on a line of its own for any lines. Folders of absolute paths,
dates and times of day count as equal; so do rules and widths of tables.
"""

import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import TypeVar

RELATIVE_TOLERANCE = 0.02
T = TypeVar("T")
ANY = "..."
TOKEN = re.compile(r"\.\.\.|[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?|\w+|[^\w\s]")
NUMBER = re.compile(r"[-+]?\d+(?:\.(\d+))?(?:e[-+]?\d+)?")
MASKED = re.compile(r"(?<![\w.])/(?:[^\s/]+/)+|\b\d{4}-\d\d-\d\d\b|\b\d\d?:\d\d(?::\d\d)?\b")
RULE = re.compile(r"[\s━─═╇┼╪╋┏┓┗┛┡┩└┘┴┯┷+=-]+")


def find_difference(shown: str, printed: str) -> tuple[int, str] | None:
    """Return the first difference between the output on a page and the printed one, or None.

    Args:
        shown: text of the block on the page.
        printed: text that the code printed.

    Returns:
        Line of `shown`, counted from 1, and the difference in words.
    """
    lines = [
        (number, line) for number, line in enumerate(shown.splitlines(), start=1) if not RULE.fullmatch(line or " ")
    ]
    expected = [_tokens(line) for _, line in lines]
    texts = [line.strip() for line in printed.splitlines() if not RULE.fullmatch(line or " ")]
    actual = [_tokens(line) for line in texts]
    if _matches(expected, actual, _is_line, [ANY]):
        return None
    for end, (number, line) in enumerate(lines, start=1):
        if not _matches([*expected[:end], [ANY]], actual, _is_line, [ANY]):
            ends = (i for i in range(len(actual) + 1) if _matches(expected[: end - 1], actual[:i], _is_line, [ANY]))
            here = [*texts, "nothing more"][next(ends)]
            near = get_close_matches(line.strip(), texts, n=1, cutoff=0.6) or [here]
            return (
                number,
                f"the page shows {line.strip()!r}, the code prints {here if near[0] == line.strip() else near[0]!r}",
            )
    return len(shown.splitlines()), f"the code prints more: {texts[-1]!r}"


def _tokens(line: str) -> list[str]:
    return TOKEN.findall(re.sub("[┃│]", "|", MASKED.sub("", line)))


def _matches(expected: Sequence[T], actual: Sequence[T], same: Callable[[T, T], bool], anything: T) -> bool:
    """Return whether two sequences are the same, where `anything` stands for any number of items."""
    if not expected:
        return not actual
    if expected[0] == anything:
        return any(_matches(expected[1:], actual[i:], same, anything) for i in range(len(actual) + 1))
    return bool(actual) and same(expected[0], actual[0]) and _matches(expected[1:], actual[1:], same, anything)


def _is_line(expected: list[str], actual: list[str]) -> bool:
    return _matches(expected, actual, _is_token, ANY)


def _is_token(expected: str, actual: str) -> bool:
    number = NUMBER.fullmatch(expected)
    if expected == actual or not number or not NUMBER.fullmatch(actual):
        return expected == actual
    last_place = 10.0 ** -len(number[1]) if number[1] else 0.0
    tolerance = max(RELATIVE_TOLERANCE * abs(float(expected)), 1.001 * last_place)
    return abs(float(expected) - float(actual)) <= tolerance
