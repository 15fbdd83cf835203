"""Commands of earlier versions, and what each is called now."""

from collections.abc import Sequence
from difflib import get_close_matches

from layflat.cli.groups import app
from layflat.cli.lazy import LazyTyper

ANY_NAME = "NAME"  # any word that is not a command of the group

PRESENT_FORMS = {
    "machines": "machine list",
    "show": "machine show",
    "check": "machine check",
    "schema": "machine schema",
    "size": "joint size",
    "design": "joint design",
    "loop": "joint sweep",
    "size-arm": "arm size",
    "arm-model": "arm export",
    "view": "arm view",
    "arm-tasks": "task list",
    f"arm-tasks {ANY_NAME}": f"task show {ANY_NAME}",
    "studies": "study list",
    f"studies {ANY_NAME}": f"study show {ANY_NAME}",
    f"study {ANY_NAME}": f"study run {ANY_NAME}",
    "motions": "motion list",
    f"motions {ANY_NAME}": f"motion show {ANY_NAME}",
    f"motion {ANY_NAME}": f"motion plan {ANY_NAME}",
    "learn": "motion learn",
    "cells": "cell list",
    f"cells {ANY_NAME}": f"cell show {ANY_NAME}",
    "pack": "cell pack",
}
"""New form of each old one; NAME stands for the word that follows."""


PRESENT_OPTIONS = {("layflat arm size", "--turn"): "--rotation", ("layflat arm size", "--pose"): "--configuration"}
"""Present name of each option that was renamed, by its command and old name."""


def moved_line(words: Sequence[str]) -> str:
    """Return the line that tells the present form of an earlier version's command line; "" for any other."""
    old, following = (*words[:2], "", "")[:2]
    key, group = f"{old} {ANY_NAME}", app.places.get(old)
    if isinstance(group, LazyTyper):
        present = [*group.places, "--help"]
        if not following or following in present or get_close_matches(following, present):
            return ""
    elif not following or following.startswith("-") or key not in PRESENT_FORMS:
        key = old
    if key not in PRESENT_FORMS:
        return ""
    name = ANY_NAME if following.startswith("-") else following
    return f"layflat {key} is layflat {PRESENT_FORMS[key]} now".replace(ANY_NAME, name)
