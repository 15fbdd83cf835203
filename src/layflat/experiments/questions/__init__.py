"""The paper's open questions: each a built-in study, with a figure and a finding made from its table.

Each has a module with `figure(study, frame)` and `finding(study, frame)`; titles and captions stand in questions.toml.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas

from layflat.arrays import Array
from layflat.experiments.axis_one import max_settling_inertia
from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque
from layflat.experiments.claim import read_texts
from layflat.files import write_text
from layflat.machine import Machine
from layflat.sim.sweep import sweep
from layflat.study import is_finished, read_study, run_study, study_table
from layflat.study.folder import ANSWER_FILES
from layflat.study.results import write_figure

STUDIED_JOINT = "small"  # in studies of one joint


def median_grid(frame: pandas.DataFrame, across: str, upward: str, column: str) -> tuple[Array, Array, Array]:
    """Return the sorted values of two columns, and the medians of a third by both, (upward, across).

    A run that diverged counts as infinite, and so does the median of runs half of which did.

    Args:
        frame: table of a study.
        across: column whose values are the first result, and the medians' second axis.
        upward: column whose values are the second result, and the medians' first axis.
        column: column of the medians.
    """
    values = frame.assign(**{column: frame[column].fillna(np.inf)})
    wide = values.groupby([upward, across])[column].quantile(0.5, interpolation="higher").unstack()
    return wide.columns.to_numpy(dtype=float), wide.index.to_numpy(dtype=float), wide.to_numpy(dtype=float)


def inertia_per_torque(machine: Machine, payload: Array) -> Array:
    """Return inertia of payloads (kg) at the end of the link, per maximum torque, kg m2 per N m."""
    return payload * machine.joint[STUDIED_JOINT].planar_link.length ** 2 / maximum_torque(machine, STUDIED_JOINT)


def inertia_limits(ratios: Array, times: Array, allowed: float) -> Array:
    """Return the largest inertia per torque, from the paper's comparison on, up to which all settle in time.

    Args:
        ratios: inertias per torque in order, (ratios,), kg m2 per N m.
        times: times to settle, (ratios, cases), s.
        allowed: upper limit of the times, s.

    Returns:
        A limit for each case, (cases,), kg m2 per N m; 0 where not even the inertia of the comparison settles.
    """
    compared = ratios >= INERTIA_PER_TORQUE
    return np.array(
        [max_settling_inertia(dict(zip(ratios[compared], case[compared], strict=True)), allowed) for case in times.T]
    )


def total_hysteresis(machine: Machine, brake: float = 1.0) -> float:
    """Return loop height over greatest torque at supply pressure, %."""
    return 100.0 * sweep(machine, STUDIED_JOINT, machine.supply.pressure_gauge, brake=brake).hysteresis


def rest_errors(frame: pandas.DataFrame, moves: Sequence[str]) -> Array:
    """Return the largest error at the end of each move, deg: mean error and half the ripple, (runs, moves)."""
    error = frame[[f"steady_error.{move}" for move in moves]].abs().to_numpy(dtype=float)
    ripple = frame[[f"ripple.{move}" for move in moves]].to_numpy(dtype=float)
    return np.asarray(np.degrees(error + 0.5 * ripple))


def move_names(frame: pandas.DataFrame) -> list[str]:
    """Return joint and number of every move of a table, such as "small.0"."""
    return [name.removeprefix("settling.") for name in frame.columns if name.startswith("settling.")]


def join_words(words: Sequence[str]) -> str:
    """Return words as a list in a sentence."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


__all__ = ["QUESTION_MODULES", "Answer", "answer_question", "read_answers", "run_question"]

_, FIGURE_FILE, FINDING_FILE = ANSWER_FILES

QUESTION_TEXTS = read_texts("questions/questions.toml")
QUESTION_MODULES: dict[str, ModuleType] = {
    name: import_module(f"{__name__}.{name.replace('-', '_')}") for name in QUESTION_TEXTS
}
"""By the name of the built-in study, in the order of the report."""


@dataclass(frozen=True)
class Answer:
    """Answer to a question of the report: its finding and its figure."""

    id: str
    title: str
    caption: str
    finding: str
    svg: str


def run_question(name: str, out: Path, progress: Callable[[int, int], None] | None = None) -> Answer:
    """Run the study of a question, or continue it, and answer the question.

    Args:
        name: name of the question's study.
        out: folder of its results.
        progress: called with the number of finished runs and the number of all.
    """
    run_study(read_study(name), out, progress=progress)
    return answer_question(name, out)


def answer_question(name: str, out: Path) -> Answer:
    """Return the answer to a question from the table of its study; its figure and text are written beside the table.

    Raises:
        InputError: there is no table.
        OutputError: the figure can't be written.
    """
    question, study, frame = QUESTION_MODULES[name], read_study(name), study_table(out)
    write_figure(question.figure(study, frame), out)
    write_text(out / FINDING_FILE, question.finding(study, frame) + "\n")
    return _read_answer(name, out)


def read_answers(out: Path) -> list[Answer]:
    """Return the answers below `out`: those of finished studies, as built in, that have table and figure."""
    complete = [name for name in QUESTION_MODULES if all((out / name / file).exists() for file in ANSWER_FILES)]
    return [_read_answer(name, out / name) for name in complete if is_finished(read_study(name), out / name)]


def _read_answer(name: str, out: Path) -> Answer:
    """Return the answer from the files of finding and figure in a folder."""
    finding, svg = ((out / file).read_text(encoding="utf-8") for file in (FINDING_FILE, FIGURE_FILE))
    return Answer(f"question-{name}", **QUESTION_TEXTS[name], finding=finding.strip(), svg=svg)
