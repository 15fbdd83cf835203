"""Sensitivity of settling and accuracy to all that the paper leaves open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layflat.experiments.axis_one import GOOD_TIME
from layflat.experiments.questions.tables import Array, listed, moves_of
from layflat.plot.bars import draw_bars
from layflat.plot.style import figure as new_figure
from layflat.study import Study
from layflat.study.sampling import Indices, sobol_indices

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

WINDOW = 2.0
"""How long a move lasts, s."""
TITLE = "Which of the paper's results depend on what we assumed?"
CAPTION = (
    "Every value that is not the paper's varies at once: what is assumed by a factor of 2, what is calibrated by 1.4, "
    "gains by 1.25. Left: in what share of all these machines a result holds. Middle and right: total Sobol indices, "
    "the share of the variance that stays if all but this one is known, with 90 % intervals; hatched what is "
    f"calibrated, dotted the gains. A move that has not settled after {WINDOW:g} s counts as that; of the error the "
    "logarithm is taken."
)
KINDS = ("assumed values", "calibrated values", "gains")
"""Groups of what varies, in the order of their looks."""
SHOWN = 10
"""Indices in the figure."""
HOLDS, FAILS = 0.9, 0.5
"""A result holds whatever was assumed if it does in this share of the machines; in less than the other it depends."""
LEAST_DISTANCE, LEAST_RIPPLE = 1e-4, np.radians(0.01)
"""Less is taken for this, where a logarithm is taken: m, rad."""

HELD = {
    "losses.weights": "they add up to one; what turn each element takes to slip varies instead",
    "hose.loss_share": "only its product with the cover's factor counts, which varies",
    "valve.centre_voltage": "driver and controller share it",
    "stops": "no move reaches them",
    "valve.volts_to_full": "a driver's range is known; another would ask for other gains in proportion",
}
"""What is not the paper's but does not vary here, and why."""


def results(frame: pandas.DataFrame) -> dict[str, Array]:
    """What is looked at in braked runs, the worst of their moves: settling (s), error of the tip (m), ripple (rad)."""
    own = frame[frame["scenario"] == "braked"]
    joints = moves_of(frame)
    tips = [name for name in frame.columns if name.startswith("tip_error.")]

    def worst(columns: list[str], most: float) -> Array:
        values: Array = own[columns].fillna(np.inf).clip(upper=most).max(axis=1).to_numpy(dtype=float)
        return values

    return {
        "settling": worst([f"settling.{name}" for name in joints], WINDOW),
        "tip error": worst(tips, 1.0),
        "ripple": worst([f"ripple.{name}" for name in joints], np.pi),
    }


def shares(study: Study, frame: pandas.DataFrame) -> dict[str, float]:
    """In what share of independently drawn machines each result holds."""
    assert study.file.runs is not None
    drawn = slice(0, 2 * study.file.runs)
    found = {name: values[drawn] for name, values in results(frame).items()}
    free = frame[frame["scenario"] == "without brake"]
    settling = free[[f"settling.{name}" for name in moves_of(frame)]].fillna(np.inf).max(axis=1).to_numpy()[drawn]
    return {
        "does not settle\nwithout brake": float(np.mean(settling > GOOD_TIME)),
        f"settles within\n{GOOD_TIME:g} s": float(np.mean(found["settling"] <= GOOD_TIME)),
        "tip within 2 mm": float(np.mean(found["tip error"] <= 2e-3)),
        "at rest within\n0.1 deg": float(np.mean(found["ripple"] <= np.radians(0.1))),
    }


def indices(study: Study, frame: pandas.DataFrame) -> dict[str, Indices]:
    """Of settling, and of the logarithms of the tip's error and of the ripple."""
    found = results(frame)
    things = len(study.blocks)
    return {
        "settling": sobol_indices(found["settling"], things),
        "tip error": sobol_indices(np.log(np.maximum(found["tip error"], LEAST_DISTANCE)), things),
        "ripple": sobol_indices(np.log(np.maximum(found["ripple"], LEAST_RIPPLE)), things),
    }


def plain(path: str) -> str:
    """A path as people read it; those of one joint stand for both."""
    return path.removeprefix("joint.large.").replace("_", " ").replace(".", " ")


def _ranked(study: Study, found: Indices) -> list[int]:
    """Numbers of what varies, the most decisive first."""
    return [int(i) for i in np.argsort(-found.total[: len(study.varied)], kind="stable")]


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Shares, and the greatest total indices of two results."""
    holds, found = shares(study, frame), indices(study, frame)
    with new_figure(1, 3, width=10.8, height=4.0, beside=0.55, between=1.75) as (made, (share, *panels)):
        draw_bars(share, list(holds), [100 * value for value in holds.values()], form="{:.0f}")
        share.set_xlim(0.0, 115.0)
        share.set_xlabel("Of all machines (%)")
        for axes, name in zip(panels, ("settling", "tip error"), strict=True):
            own = found[name]
            top = _ranked(study, own)[:SHOWN]
            kinds = [KINDS.index(study.varied[i].group or KINDS[0]) for i in top]
            ends = [(own.total_ends[0, i], own.total_ends[1, i]) for i in top]
            draw_bars(
                axes, [plain(study.varied[i].path) for i in top], [own.total[i] for i in top], ends=ends, kinds=kinds
            )
            axes.set_xlabel(f"Total index of {name}")
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Which results hold whatever was assumed, which do not, and what decides."""
    holds, found = shares(study, frame), indices(study, frame)
    sentences = []
    for group, words in (
        ({k: v for k, v in holds.items() if v >= HOLDS}, "holds whatever was assumed"),
        ({k: v for k, v in holds.items() if FAILS <= v < HOLDS}, "holds in most machines"),
        ({k: v for k, v in holds.items() if v < FAILS}, "depends on what was assumed"),
    ):
        if group:
            named = [f"“{' '.join(name.split())}” ({100 * value:.0f} %)" for name, value in group.items()]
            sentences.append(f"{listed(named)} {words if len(named) == 1 else words.replace('s ', ' ', 1)}.")
    for name, own in found.items():
        top = [f"{plain(study.varied[i].path)} ({own.total[i]:.2f})" for i in _ranked(study, own)[:3]]
        sentences.append(f"{'Settling' if name == 'settling' else 'The ' + name} depends most on {listed(top)}.")
    return " ".join([*sentences, _groups(study, found["settling"])]).strip()


def _groups(study: Study, own: Indices) -> str:
    """How much of the variance of settling goes with each group alone."""
    each = {name: float(own.first[i]) for i, name in enumerate(study.blocks) if i >= len(study.varied)}
    if not each:
        return ""
    said = [f"{100 * max(value, 0.0):.0f} % with {name}" for name, value in each.items()]
    rest = 100 * max(1.0 - sum(max(value, 0.0) for value in each.values()), 0.0)
    return f"Of the variance of settling {listed(said)} alone would go; {rest:.0f} % is in how these meet."
