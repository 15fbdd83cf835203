"""Each rule of the language check finds what breaks it, leaves what does not, and can be excepted with a reason."""

from dataclasses import replace
from pathlib import Path

import pytest

from lint.findings import Words
from lint.language import Module, check_classes, check_module, check_repository
from lint.pages import check_page

WORDS = replace(Words.read(), pending=())
ARGS = '"""Return a value.\n\n    Args:\n        a: first.\n    """'

BROKEN = [
    ("constant", "MOST = 3\n"),
    ("constant", "NEAR, MAX_GAP = 1, 2\n"),
    ("constant", "_CALM: float = 0.1\n"),
    ("docstring", '"""What is there."""\n'),
    ("docstring", 'class Valve:\n    size: int\n    """How large it is."""\n'),
    ("docstring", 'async def open_valve():\n    """Whether it opens."""\n'),
    ("function", "def _told(): ...\n"),
    ("function", "class Valve:\n    def at(self): ...\n"),
    ("parameter", "def open_valve(given): ...\n"),
    ("parameter", "def outer():\n    def inner(*, found): ...\n"),
    ("arguments", "def open_valve(a, b, *, c): ...\n"),
    ("arguments", "class Valve:\n    def open(self, a, b, c): ...\n"),
    ("message", 'raise InputError(f"the posture of {1}")\n'),
    ("message", 'raise DriverError("it opens the valves as it lets out the air")\n'),
    ("message", 'raise LayflatError("the check was broken off, and the air let out")\n'),
]

SOUND = [
    "GAMMA, MAX_GAP, __all__ = 1.4, 2, []\n",
    '"""Whatever it is, a state."""\n',
    "def whether_open(angle): ...\n",
    f"def open_valve(a, b, c):\n    {ARGS}\n",
    "def _open_valve(a, b, c): ...\n",
    "def outer():\n    def inner(a, b, c): ...\n",
    "@law\ndef force(a, b, c): ...\n",
    "@app.command('open')\ndef open_valve(a, b, c): ...\n",
    "MOST = 3  # language: named so by the standard\n",
    'print("the posture")\n',
]


def rules(text: str) -> list[str]:
    """The rules that a module breaks."""
    return [one.rule for one in check_module(Module(Path("a.py"), text), WORDS)]


@pytest.mark.parametrize(("rule", "text"), BROKEN)
def test_what_breaks_a_rule_is_found(rule: str, text: str) -> None:
    assert rules(text) == [rule]


@pytest.mark.parametrize("text", SOUND)
def test_what_breaks_none_is_left(text: str) -> None:
    assert rules(text) == []


def test_classes_of_one_name_are_found_unless_a_contract_defines_them() -> None:
    modules = [Module(Path(f"{name}.py"), "class Line: ...\nclass Settings: ...\n") for name in "ab"]
    assert [(str(one.path), one.line) for one in check_classes(modules, WORDS)] == [("a.py", 1), ("b.py", 1)]
    assert not [*check_classes(modules[:1], WORDS)]


PAGES = [
    ("page", 3, "# A\n\nThe posture.\n"),
    ("page", 4, "# A\n\nIt stands\nat\nrest.\n"),
    ("heading", 3, "# A\n\n## What it does\nB.\n"),
    ("first sentence", 2, "# A\nHow it works.\n"),
    ("sentence", 4, "# A\nB.\n\nOf any scenario.\n"),
    ("sentence", 3, "# A\n\nA joint. Of any\nscenario. More.\n"),
    ("sentence", 3, "# A\n\n- Of a simulated run a log has them.\n"),
]


@pytest.mark.parametrize(("rule", "line", "text"), PAGES)
def test_pages_have_rules_of_their_own(rule: str, line: int, text: str) -> None:
    assert [(one.rule, one.line) for one in check_page(Path("a.md"), text, WORDS)] == [(rule, line)]


def test_pages_are_read_outside_of_code_comments_and_links() -> None:
    code = "A [link](posture.md).\n```\nposture\n```\nThe key `posture`.\n<!-- posture -->\n"
    sound = "# How-to guides\nA. Of the twenty, 18 settle. It draws least squares. At least one.\n"
    assert not [*check_page(Path("a.md"), sound + code, WORDS)]


def test_the_repository_holds_its_rules() -> None:
    assert check_repository() == []
