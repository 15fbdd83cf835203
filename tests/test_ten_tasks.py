"""The ten most usual tasks as a notebook has them: cell by cell, in at most five lines of names at the top each."""

import ast
import re
from pathlib import Path
from typing import Any

import pytest

import layflat

SCRIPT = Path(__file__).parents[1] / "examples" / "ten_tasks.py"
MAX_LINES = 5
TASKS = ["Load", "Change", "Simulate", "Plot", "Measure", "Vary", "Size", "Tune", "Identify", "Plan a motion"]


def cells() -> list[tuple[str, str]]:
    """Titles and codes of the cells; the first has the imports."""
    parts = re.split(r"^# %%\n", SCRIPT.read_text(encoding="utf-8"), flags=re.MULTILINE)
    titles = ["", *(part.partition("\n")[0].removeprefix("# ") for part in parts[1:])]
    return [
        (title, re.sub(r"^#.*\n", "", part, flags=re.MULTILINE).strip())
        for title, part in zip(titles, parts, strict=True)
    ]


def test_every_task_takes_at_most_five_lines_of_names_at_the_top() -> None:
    (_, first), *tasks = cells()
    assert [title for title, _ in tasks] == TASKS
    assert {
        alias.name for node in ast.walk(ast.parse(first)) if isinstance(node, ast.Import) for alias in node.names
    } == {"layflat", "numpy"}
    for title, code in tasks:
        assert len(code.splitlines()) <= MAX_LINES, title
        assert set(re.findall(r"\blf\.(\w+)", code)) <= set(layflat.__all__), title


@pytest.mark.compiled
def test_the_notebook_runs_and_every_result_shows_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As Jupyter runs cells: the value of a last expression is shown, as a picture or as a table."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for title, code in cells():
        tree = ast.parse(code)
        last = tree.body[-1]
        exec(compile(ast.Module(tree.body[:-1], []), str(SCRIPT), "exec"), names)
        if isinstance(last, ast.Expr):
            assert shown(eval(compile(ast.Expression(last.value), str(SCRIPT), "eval"), names)), title
        else:
            exec(compile(ast.Module([last], []), str(SCRIPT), "exec"), names)


def shown(value: Any) -> bool:
    """Return whether a notebook shows a value as a picture or as a table."""
    picture = value._repr_png_() if hasattr(value, "_repr_png_") else b""
    return bool(picture.startswith(b"\x89PNG")) or "<table>" in (value._repr_html_() or "")
