"""The paper's open questions: each a built-in study, with a figure and a finding made from its table.

Each module has a TITLE, a CAPTION, `figure(study, frame)` and `finding(study, frame)`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
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
from layflat.study.folder import ANSWER

__all__ = ["QUESTIONS", "Answer", "answer", "answers", "ask"]

PNG, SVG, TEXT = ANSWER

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


def ask(name: str, out: Path, progress: Callable[[int, int], None] | None = None) -> Answer:
    """Run the study of a question, or what is left of it, and answer it."""
    run(read(name), out, progress=progress)
    return answer(name, out)


def answer(name: str, out: Path) -> Answer:
    """The answer to a question from the table of its study; its figure and text are written beside the table.

    Raises:
        InputError: there is no table.
        OutputError: the figure can't be written.
    """
    question, study, frame = QUESTIONS[name], read(name), table(out)
    drawn = question.figure(study, frame)
    found = Answer(f"question-{name}", question.TITLE, question.CAPTION, question.finding(study, frame), to_svg(drawn))
    save(drawn, out / PNG)
    for file, text in ((SVG, found.svg), (TEXT, found.finding + "\n")):
        with whole_file(out / file) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return found


def answers(out: Path) -> list[Answer]:
    """What is answered below `out`: questions whose tables, of these very studies, are there with their figures."""
    return [_kept(name, out / name) for name in QUESTIONS if _is_answered(name, out / name)]


def _is_answered(name: str, out: Path) -> bool:
    return all((out / file).exists() for file in ANSWER) and finished(read(name), out)


def _kept(name: str, out: Path) -> Answer:
    question = QUESTIONS[name]
    finding, svg = ((out / file).read_text(encoding="utf-8") for file in (TEXT, SVG))
    return Answer(f"question-{name}", question.TITLE, question.CAPTION, finding.strip(), svg)
