"""The paper's open questions: each a built-in study, with a figure and a finding made from its table.

Each has a module with `figure(study, frame)` and `finding(study, frame)`; titles and captions stand in questions.toml.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

from layflat.experiments.claim import texts_of
from layflat.files import write_text
from layflat.study import finished, read, run, table
from layflat.study.folder import ANSWER
from layflat.study.results import write_figure

__all__ = ["QUESTIONS", "Answer", "answer", "answers", "ask"]

_, SVG, TEXT = ANSWER

TEXTS = texts_of("questions/questions.toml")
QUESTIONS: dict[str, ModuleType] = {name: import_module(f"{__name__}.{name.replace('-', '_')}") for name in TEXTS}
"""By the name of the built-in study, in the order of the report."""


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
    """Return the answer to a question from the table of its study; its figure and text are written beside the table.

    Raises:
        InputError: there is no table.
        OutputError: the figure can't be written.
    """
    question, study, frame = QUESTIONS[name], read(name), table(out)
    write_figure(question.figure(study, frame), out)
    write_text(out / TEXT, question.finding(study, frame) + "\n")
    return _kept(name, out)


def answers(out: Path) -> list[Answer]:
    """Return what is answered below `out`: whose tables, of these very studies, are there with their figures."""
    there = [name for name in QUESTIONS if all((out / name / file).exists() for file in ANSWER)]
    return [_kept(name, out / name) for name in there if finished(read(name), out / name)]


def _kept(name: str, out: Path) -> Answer:
    finding, svg = ((out / file).read_text(encoding="utf-8") for file in (TEXT, SVG))
    return Answer(f"question-{name}", **TEXTS[name], finding=finding.strip(), svg=svg)
