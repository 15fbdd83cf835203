"""The paper's open questions: each a built-in study, with a figure and a finding made from its table.

Each module has a TITLE, a CAPTION, `figure(study, frame)` and `finding(study, frame)`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType

from layflat.experiments.questions import (
    assumptions,
    brake_and_inertia,
    dither,
    losses_and_brake,
    supply_pressure,
    valves,
)
from layflat.files import whole_file
from layflat.plot.style import save, to_svg
from layflat.study import finished, read, run, table

__all__ = ["QUESTIONS", "Answer", "answer", "answers", "ask", "write_answer"]

QUESTIONS: dict[str, ModuleType] = {
    "brake-and-inertia": brake_and_inertia,
    "losses-and-brake": losses_and_brake,
    "dither": dither,
    "valves": valves,
    "supply-pressure": supply_pressure,
    "assumptions": assumptions,
}
"""By the name of the built-in study."""


@dataclass(frozen=True)
class Answer:
    """A question of the report with its finding and its figure."""

    id: str
    title: str
    caption: str
    finding: str
    svg: str


def ask(out: Path, progress: Callable[[str, int, int], None]) -> None:
    """Run the study of every question, or what is left of it, each in its folder below `out`."""
    for name in QUESTIONS:
        run(read(name), out / name, progress=partial(progress, name))


def answers(out: Path) -> list[Answer]:
    """What is answered below `out`: questions whose whole tables, of these very studies, are there."""
    if not out.is_dir():
        return []
    return [
        answer(name, out / name) for name in QUESTIONS if (out / name).is_dir() and finished(read(name), out / name)
    ]


def answer(name: str, out: Path) -> Answer:
    """The answer to a question from the table of its study."""
    question, study, frame = QUESTIONS[name], read(name), table(out)
    svg = to_svg(question.figure(study, frame))
    return Answer(f"question-{name}", question.TITLE, question.CAPTION, question.finding(study, frame), svg)


def write_answer(name: str, out: Path) -> str:
    """Write the figure of a question beside the table of its study, as SVG and PNG; returns its finding."""
    question, study, frame = QUESTIONS[name], read(name), table(out)
    drawn = question.figure(study, frame)
    save(drawn, out / "figure.png")
    with whole_file(out / "figure.svg") as temporary:
        temporary.write_text(to_svg(drawn), encoding="utf-8")
    return str(question.finding(study, frame))
