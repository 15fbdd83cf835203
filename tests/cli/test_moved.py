"""Commands of earlier versions: one line says what each is called now."""

import pytest
import typer.main

from docs.site.commands import walk_commands
from layflat.cli import app
from layflat.cli.moved import ANY_NAME, PRESENT_FORMS, moved_line
from layflat.motion.file import MOTION_LIBRARY
from layflat.study import study_names
from tests.cli.commands import refused


@pytest.mark.parametrize(("old", "new"), PRESENT_FORMS.items())
def test_an_old_command_says_the_new_one(old: str, new: str) -> None:
    typed, now = (words.replace(ANY_NAME, "mine.toml") for words in (old, new))
    for following in ("", " --help", " -o out"):
        assert refused(*f"{typed}{following}".split()) == f"layflat: layflat {typed} is layflat {now} now"


def test_every_new_command_is_there() -> None:
    present = {words for words, _ in walk_commands(typer.main.get_command(app), "layflat")}
    assert {f"layflat {new.removesuffix(f' {ANY_NAME}')}" for new in PRESENT_FORMS.values()} <= present


@pytest.mark.parametrize(
    ("group", "verb", "names"), [("study", "run", study_names()), ("motion", "plan", MOTION_LIBRARY.names)]
)
def test_a_built_in_name_is_not_taken_for_a_mistyped_verb(group: str, verb: str, names: tuple[str, ...]) -> None:
    for name in names:
        assert moved_line([group, name]) == f"layflat {group} {name} is layflat {group} {verb} {name} now"
    assert moved_line([group, "-o", "out", "x"]) == f"layflat {group} NAME is layflat {group} {verb} NAME now"


@pytest.mark.parametrize(
    "words",
    [[], ["--version"], ["study"], ["study", "--help"], ["study", "list"], ["simulate", "paper-arm"], ["study", "rn"]],
)
def test_a_present_command_has_not_moved(words: list[str]) -> None:
    assert moved_line(words) == ""


@pytest.mark.parametrize(
    ("typed", "nearest"),
    [("machin list", "machine"), ("machine lst", "list"), ("study rnu paper", "run"), ("motion plna tour", "plan")],
)
def test_a_mistyped_command_names_the_nearest(typed: str, nearest: str) -> None:
    assert f"Did you mean '{nearest}'?" in refused(*typed.split())
