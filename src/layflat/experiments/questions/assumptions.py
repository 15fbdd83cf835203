"""Sensitivity of settling and accuracy to all that the paper leaves open."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import GOOD_TIME
from layflat.experiments.questions.tables import listed, moves_of
from layflat.plot.bars_and_maps import draw_bars
from layflat.plot.style import figure as new_figure
from layflat.study import Study
from layflat.study.sampling import Indices, sobol_indices

WINDOW = 2.0  # how long a move lasts, s
KINDS = ("assumed values", "calibrated values", "gains")  # groups of what varies, in the order of their looks
SHOWN = 10  # indices in the figure
HOLDS, FAILS = 0.9, 0.5
"""A result holds whatever was assumed if it does in this share of the machines; in less than the other it depends."""
LEAST = {"tip error": 1e-4, "ripple": np.radians(0.01)}  # less is taken for this, where a logarithm is taken: m, rad


def _worst(frame: pandas.DataFrame, names: list[str], most: float) -> Array:
    """Of several columns; what is not finite, or more than the most, counts as that."""
    return np.asarray(frame[names].fillna(np.inf).clip(upper=most).max(axis=1), dtype=float)


def results(frame: pandas.DataFrame) -> dict[str, Array]:
    """Return the worst of the moves of braked runs: settling (s), error of the tip (m), ripple (rad)."""
    own, moves = frame[frame["scenario"] == "braked"], moves_of(frame)
    tips = [name for name in frame.columns if name.startswith("tip_error.")]
    return {
        "settling": _worst(own, [f"settling.{name}" for name in moves], WINDOW),
        "tip error": _worst(own, tips, 1.0),
        "ripple": _worst(own, [f"ripple.{name}" for name in moves], np.pi),
    }


def shares(study: Study, frame: pandas.DataFrame) -> dict[str, float]:
    """Return in what share of independently drawn machines each result holds."""
    free = frame[frame["scenario"] == "without brake"]
    unbraked = _worst(free, [f"settling.{name}" for name in moves_of(frame)], np.inf)
    found = results(frame)
    holds = {
        "does not settle\nwithout brake": unbraked > GOOD_TIME,
        f"settles within\n{GOOD_TIME:g} s": found["settling"] <= GOOD_TIME,
        "tip within 2 mm": found["tip error"] <= 2e-3,
        "at rest within\n0.1 deg": found["ripple"] <= np.radians(0.1),
    }
    return {name: float(np.mean(own[: 2 * (study.file.runs or 0)])) for name, own in holds.items()}


def indices(study: Study, frame: pandas.DataFrame) -> dict[str, Indices]:
    """Return the indices of settling, and of the logarithms of the tip's error and of the ripple."""
    found = results(frame)
    found |= {key: np.log(np.maximum(found[key], least)) for key, least in LEAST.items()}
    return {key: sobol_indices(values, len(study.blocks)) for key, values in found.items()}


def plain(path: str) -> str:
    """Return a path as people read it; those of one joint stand for both."""
    return path.removeprefix("joint.large.").replace("_", " ").replace(".", " ")


def _ranked(study: Study, found: Indices) -> list[int]:
    """Numbers of what varies, the most decisive first."""
    return [int(i) for i in np.argsort(-found.total[: len(study.varied)], kind="stable")]


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw shares, and the greatest total indices of two results."""
    holds, found = shares(study, frame), indices(study, frame)
    with new_figure(1, 3, width=10.8, height=4.0, beside=0.55, between=1.75) as (made, (share, *panels)):
        draw_bars(share, list(holds), [100 * value for value in holds.values()], form="{:.0f}")
        share.set(xlim=(0.0, 115.0), xlabel="Of all machines (%)")
        for axes, name in zip(panels, ("settling", "tip error"), strict=True):
            own, top = found[name], _ranked(study, found[name])[:SHOWN]
            draw_bars(
                axes,
                [plain(study.varied[i].path) for i in top],
                own.total[top].tolist(),
                ends=[(low, high) for low, high in own.total_ends[:, top].T],
                kinds=[KINDS.index(study.varied[i].group or KINDS[0]) for i in top],
            )
            axes.set_xlabel(f"Total index of {name}")
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Say which results hold whatever was assumed, which do not, and what decides."""
    holds, found = shares(study, frame), indices(study, frame)
    sentences = []
    for low, high, one, more in (
        (HOLDS, np.inf, "holds whatever was assumed", "hold whatever was assumed"),
        (FAILS, HOLDS, "holds in most machines", "hold in most machines"),
        (-1.0, FAILS, "depends on what was assumed", "depend on what was assumed"),
    ):
        named = [f"“{' '.join(k.split())}” ({100 * v:.0f} %)" for k, v in holds.items() if low <= v < high]
        if named:
            sentences.append(f"{listed(named)} {one if len(named) == 1 else more}.")
    for name, own in found.items():
        top = [f"{plain(study.varied[i].path)} ({own.total[i]:.2f})" for i in _ranked(study, own)[:3]]
        sentences.append(f"{'Settling' if name == 'settling' else 'The ' + name} depends most on {listed(top)}.")
    # How much of the variance of settling goes with each group alone.
    groups = study.blocks[len(study.varied) :]
    each = [max(float(value), 0.0) for value in found["settling"].first[len(study.varied) :]]
    if groups:
        said = listed([f"{100 * value:.0f} % with {name}" for name, value in zip(groups, each, strict=True)])
        rest = 100 * max(1.0 - sum(each), 0.0)
        sentences.append(f"Of the variance of settling {said} alone would go; {rest:.0f} % is in how these meet.")
    return " ".join(sentences)
