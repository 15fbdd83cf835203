"""A comparison on disk: beyond.json, and one page that needs nothing else."""

import json
from collections.abc import Iterator
from math import degrees, isfinite
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from layflat._version import __version__
from layflat.experiments.beyond import settling
from layflat.experiments.beyond.comparison import TRACKING, Comparison
from layflat.experiments.beyond.moves import POSTURES
from layflat.experiments.beyond.settling import Settling, heaviest
from layflat.files import write_text
from layflat.plot.bars_and_maps import draw_bars
from layflat.plot.page import Drawn, page
from layflat.plot.style import figure, to_svg
from layflat.plot.tuning import settled_shares
from layflat.tune.robust import STATEMENT

WINDOW = 1.5  # s
ABLATION = (
    "Time within which 95 of 100 steps settle on plants that differ, without each part of the law. Where a bar "
    "comes to 1.5 s, they do not."
)
COLUMNS = ("case", "law", "runs", "median (s)", "95 % (s)", "not settled")

Number = float | int | None


def rows(of: list[Settling]) -> list[list[str]]:
    """Return rows with `COLUMNS`."""
    return [
        [one.case, one.law, str(one.times.size), _seconds(one.median), _seconds(one.late), str(one.unsettled)]
        for one in of
    ]


def _seconds(time: float) -> str:
    return f"{time:.3f}" if isfinite(time) else "never"


def numbers(found: Comparison) -> dict[str, Number]:
    """Return what was found, by the names in beyond.json; None for what the machine can't do."""

    def late(case: str, law: str = TRACKING) -> Number:
        one = found.of(law, case)
        return None if one is None else _number(one.late)

    def median(case: str, law: str = TRACKING) -> Number:
        one = found.of(law, case)
        return None if one is None else _number(one.median)

    def unsettled(case: str) -> Number:
        one = found.of(TRACKING, case)
        return None if one is None else one.unsettled

    told: dict[str, Number] = {
        "nominal_settling_median_s": median(settling.NOMINAL),
        "nominal_settling_95_s": late(settling.NOMINAL),
        "delayed_settling_95_s": late(settling.LATE),
        "robust_settling_95_s": late(settling.ROBUST),
        "robust_unsettled": unsettled(settling.ROBUST),
        "unknown_payload_first_95_s": late(settling.FIRST),
        "unknown_payload_later_95_s": late(settling.LATER),
        "robust_unknown_payload_95_s": late(settling.BOTH),
        "robust_unknown_payload_unsettled": unsettled(settling.BOTH),
        "gravity_unknown_payload_95_s": None if found.upright is None else _number(found.upright.late),
    }
    for speed, name in ((0.3, "0p3"), (0.5, "0p5")):
        belt = found.belt(TRACKING, speed)
        told[f"conveyor_{name}_rms_mm"] = None if belt is None else 1e3 * belt.rms
        told[f"conveyor_{name}_max_mm"] = None if belt is None else 1e3 * belt.most
    stiff, rest, ratios = found.stiffness, found.resting, found.ratios
    told |= {
        "stiffness_spread_percent": None if stiff is None else 100.0 * stiff.spread,
        "stiffness_moved_deg": None if stiff is None else degrees(float(stiff.moved.max())),
        "learnt_error_ratio": found.learnt,
        "rest_moved_deg": None if rest is None else degrees(rest.moved),
        "rest_air_saved_percent": None if rest is None else 100.0 * (1.0 - rest.air),
        "bound_median_s": _number(float(np.median(found.bounds))) if found.bounds.size else None,
        "bound_ratio_median": _number(float(np.median(ratios))) if ratios.size else None,
        "bound_ratio_95": _number(float(np.quantile(ratios, 0.95, method="higher"))) if ratios.size else None,
    }
    for one in found.settling:
        if one.law != TRACKING and one.case == settling.NOMINAL:
            told[f"{_key(one.law)}_nominal_settling_95_s"] = _number(one.late)
    for one in found.ablations:
        told[f"{_key(one.law)}_robust_settling_95_s"] = _number(one.late)
    return told


def _key(law: str) -> str:
    return law.replace("the paper's", "papers").replace(", ", "_").replace(" ", "_")


def _number(value: float) -> Number:
    """Return a number that JSON has; None for a time that never comes."""
    return value if isfinite(value) else None


def write_numbers(found: Comparison, path: Path) -> Path:
    """Write beyond.json (OutputError: it can't be written there)."""
    return write_text(path, json.dumps(numbers(found), indent=2, allow_nan=False) + "\n")


def write_page(found: Comparison, path: Path) -> Path:
    """Write the page (OutputError: it can't be written there)."""
    html = page(
        "layflat.experiments.beyond",
        "beyond.html.j2",
        machine=found.machine.title,
        version=__version__,
        robust=STATEMENT,
        postures=POSTURES,
        heaviest=f"{heaviest(found.machine):g}",
        columns=COLUMNS,
        rows=rows(found.settling),
        ablations=rows(found.ablations),
        numbers=numbers(found),
        belts=[[one.law, f"{one.speed:g}", f"{1e3 * one.rms:.2f}", f"{1e3 * one.most:.2f}"] for one in found.following],
        figures=list(_figures(found)),
    )
    return write_text(path, html)


def _figures(found: Comparison) -> Iterator[Drawn]:
    for name, case in (("nominal", settling.NOMINAL), ("robust", settling.ROBUST), ("both", settling.BOTH)):
        shares = {one.law: one.times for one in found.settling if one.case == case}
        caption = "How many of all steps of 40 deg have the tip within 2 mm of its goal for good, by time."
        if case == settling.NOMINAL and found.bounds.size == POSTURES:
            shares["openings found offline"] = found.bounds
            caption += " Openings that are found offline know all of the plant, and meet no noise."
        yield Drawn(name, f"Steps: {case}.", caption, to_svg(settled_shares(shares, None, WINDOW)))
    if found.ablations:
        yield Drawn("ablation", "What each part of the law is for.", ABLATION, to_svg(_late_bars(found)))


def _late_bars(found: Comparison) -> Figure:
    whole = found.of(TRACKING, settling.ROBUST)
    of = [] if whole is None else [whole]
    names = [*("all of it" for _ in of), *(one.law.removeprefix("tracking, ") for one in found.ablations)]
    late = [min(one.late, WINDOW) for one in [*of, *found.ablations]]
    with figure(height=3.4, beside=1.1) as (made, (axes,)):
        draw_bars(axes, names, late, kinds=[*(0 for _ in of), *(1 for _ in found.ablations)], form="{:.2f}")
        axes.set_xlabel("Time within which 95 % settle (s)")
        axes.set_xlim(0.0, 1.1 * WINDOW)
    return made
