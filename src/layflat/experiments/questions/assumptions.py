"""Sensitivity of settling and accuracy to all parameters that the paper leaves open."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import SETTLING_GOAL
from layflat.experiments.questions import join_words, move_names
from layflat.plot.bars_and_maps import draw_bars
from layflat.plot.style import styled_figure as new_figure
from layflat.study import Study
from layflat.study.sampling import SobolIndices, sobol_indices

MOVE_DURATION = 2.0  # of a move, s
INPUT_GROUPS = ("assumed values", "calibrated values", "gains")  # of varied parameters, in the order of their colours
SHOWN_INDICES = 10  # number in the figure
HOLDING_FRACTION, FAILING_FRACTION = 0.9, 0.5
"""Fraction of machines from which on a result holds whatever was assumed; and that below which it depends on it."""
LOGARITHM_FLOORS = {"tip error": 1e-4, "ripple": np.radians(0.01)}  # lower bounds before a logarithm: m, rad


def _max_of_columns(frame: pandas.DataFrame, names: list[str], limit: float) -> Array:
    """Return the greatest value of several columns, row by row, cut to `limit`; `limit` where one is no number."""
    return np.asarray(frame[names].fillna(np.inf).clip(upper=limit).max(axis=1), dtype=float)


def worst_results(frame: pandas.DataFrame) -> dict[str, Array]:
    """Return the worst of the moves of each braked run: "settling" (s), "tip error" (m), "ripple" (rad), (runs,).

    They are cut to `MOVE_DURATION`, 1 m and pi, which are also those of a run that diverged.
    """
    braked, moves = frame[frame["scenario"] == "braked"], move_names(frame)
    tips = [name for name in frame.columns if name.startswith("tip_error.")]
    return {
        "settling": _max_of_columns(braked, [f"settling.{name}" for name in moves], MOVE_DURATION),
        "tip error": _max_of_columns(braked, tips, 1.0),
        "ripple": _max_of_columns(braked, [f"ripple.{name}" for name in moves], np.pi),
    }


def holding_fractions(study: Study, frame: pandas.DataFrame) -> dict[str, float]:
    """Return the fraction of independently drawn machines in which each result holds, by its label in the figure."""
    free = frame[frame["scenario"] == "without brake"]
    unbraked = _max_of_columns(free, [f"settling.{name}" for name in move_names(frame)], np.inf)
    worst = worst_results(frame)
    holds = {
        "does not settle\nwithout brake": unbraked > SETTLING_GOAL,
        f"settles within\n{SETTLING_GOAL:g} s": worst["settling"] <= SETTLING_GOAL,
        "tip within 2 mm": worst["tip error"] <= 2e-3,
        "at rest within\n0.1 deg": worst["ripple"] <= np.radians(0.1),
    }
    return {name: float(np.mean(outcome[: 2 * (study.file.runs or 0)])) for name, outcome in holds.items()}


def result_indices(study: Study, frame: pandas.DataFrame) -> dict[str, SobolIndices]:
    """Return Sobol indices of settling, and of the logarithms of tip error and ripple, by keys of `worst_results`."""
    results = worst_results(frame)
    results |= {key: np.log(np.maximum(results[key], floor)) for key, floor in LOGARITHM_FLOORS.items()}
    return {key: sobol_indices(values, len(study.blocks)) for key, values in results.items()}


def readable_path(path: str) -> str:
    """Return a parameter's path as words; those of one joint stand for both."""
    return path.removeprefix("joint.large.").replace("_", " ").replace(".", " ")


def _rank_inputs(study: Study, indices: SobolIndices) -> list[int]:
    """Return the numbers of the varied parameters by their total index, greatest first."""
    return [int(i) for i in np.argsort(-indices.total[: len(study.varied)], kind="stable")]


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw the fractions of machines in which results hold, and the greatest total indices of two results."""
    holds, sobol = holding_fractions(study, frame), result_indices(study, frame)
    with new_figure(1, 3, width=10.8, height=4.0, beside=0.55, between=1.75) as (fig, (share, *panels)):
        draw_bars(share, list(holds), [100 * value for value in holds.values()], form="{:.0f}")
        share.set(xlim=(0.0, 115.0), xlabel="Of all machines (%)")
        for axes, name in zip(panels, ("settling", "tip error"), strict=True):
            index, ranked = sobol[name], _rank_inputs(study, sobol[name])[:SHOWN_INDICES]
            draw_bars(
                axes,
                [readable_path(study.varied[i].path) for i in ranked],
                index.total[ranked].tolist(),
                ends=[(low, high) for low, high in index.total_ends[:, ranked].T],
                kinds=[INPUT_GROUPS.index(study.varied[i].group or INPUT_GROUPS[0]) for i in ranked],
            )
            axes.set_xlabel(f"Total index of {name}")
    return fig


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Return text on the results that hold whatever was assumed, those that do not, and the decisive parameters."""
    holds, sobol = holding_fractions(study, frame), result_indices(study, frame)
    sentences = []
    for low, high, singular, plural in (
        (HOLDING_FRACTION, np.inf, "holds whatever was assumed", "hold whatever was assumed"),
        (FAILING_FRACTION, HOLDING_FRACTION, "holds in most machines", "hold in most machines"),
        (-1.0, FAILING_FRACTION, "depends on what was assumed", "depend on what was assumed"),
    ):
        named = [f"“{' '.join(k.split())}” ({100 * v:.0f} %)" for k, v in holds.items() if low <= v < high]
        if named:
            sentences.append(f"{join_words(named)} {singular if len(named) == 1 else plural}.")
    for name, index in sobol.items():
        decisive = [
            f"{readable_path(study.varied[i].path)} ({index.total[i]:.2f})" for i in _rank_inputs(study, index)[:3]
        ]
        sentences.append(
            f"{'Settling' if name == 'settling' else 'The ' + name} depends most on {join_words(decisive)}."
        )
    # Fraction of the variance of settling that each group explains alone.
    groups = study.blocks[len(study.varied) :]
    group_fractions = [max(float(value), 0.0) for value in sobol["settling"].first[len(study.varied) :]]
    if groups:
        fractions = join_words(
            [f"{100 * value:.0f} % with {name}" for name, value in zip(groups, group_fractions, strict=True)]
        )
        interaction = 100 * max(1.0 - sum(group_fractions), 0.0)
        sentences.append(
            f"Of the variance of settling {fractions} alone would go; {interaction:.0f} % is in how these meet."
        )
    return " ".join(sentences)
