"""Results of a comparison on disk: beyond.json, and one self-contained page."""

import json
from collections.abc import Iterator
from math import degrees, isfinite
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from layflat._version import __version__
from layflat.experiments.beyond import settling
from layflat.experiments.beyond.comparison import TRACKING_LABEL, Comparison
from layflat.experiments.beyond.moves import CONFIGURATION_COUNT
from layflat.experiments.beyond.settling import Settling, max_payload
from layflat.files import write_text
from layflat.plot import CaptionedFigure, render_page
from layflat.plot.bars_and_maps import draw_bars
from layflat.plot.style import styled_figure, to_svg
from layflat.plot.tuning import settled_fraction_figure
from layflat.tune.robust import ROBUST_SET_TEXT

SETTLING_WINDOW = 1.5  # upper end of settling times in figures, s
ABLATION_CAPTION = (
    "Time within which 95 of 100 steps settle on plants that differ, without each part of the law. Where a bar "
    "comes to 1.5 s, they do not."
)
COLUMNS = ("case", "law", "runs", "median (s)", "95 % (s)", "not settled")

Number = float | int | None


def settling_rows(results: list[Settling]) -> list[list[str]]:
    """Return table rows by `COLUMNS`."""
    return [
        [one.case, one.law, str(one.times.size), _seconds(one.median), _seconds(one.late), str(one.unsettled)]
        for one in results
    ]


def _seconds(time: float) -> str:
    return f"{time:.3f}" if isfinite(time) else "never"


def result_numbers(comparison: Comparison) -> dict[str, Number]:
    """Return the results by their keys in beyond.json; None for what the machine can't do, or is not finite."""

    def late(case: str, law: str = TRACKING_LABEL) -> Number:
        one = comparison.settling_of(law, case)
        return None if one is None else _finite_or_none(one.late)

    def median(case: str, law: str = TRACKING_LABEL) -> Number:
        one = comparison.settling_of(law, case)
        return None if one is None else _finite_or_none(one.median)

    def unsettled(case: str) -> Number:
        one = comparison.settling_of(TRACKING_LABEL, case)
        return None if one is None else one.unsettled

    numbers: dict[str, Number] = {
        "nominal_settling_median_s": median(settling.NOMINAL_CASE),
        "nominal_settling_95_s": late(settling.NOMINAL_CASE),
        "delayed_settling_95_s": late(settling.DELAYED_CASE),
        "robust_settling_95_s": late(settling.ROBUST_CASE),
        "robust_unsettled": unsettled(settling.ROBUST_CASE),
        "unknown_payload_first_95_s": late(settling.FIRST_MOVE_CASE),
        "unknown_payload_later_95_s": late(settling.LATER_MOVES_CASE),
        "robust_unknown_payload_95_s": late(settling.ROBUST_PAYLOAD_CASE),
        "robust_unknown_payload_unsettled": unsettled(settling.ROBUST_PAYLOAD_CASE),
        "gravity_unknown_payload_95_s": None
        if comparison.upright is None
        else _finite_or_none(comparison.upright.late),
    }
    for speed, name in ((0.3, "0p3"), (0.5, "0p5")):
        belt = comparison.belt_following_of(TRACKING_LABEL, speed)
        numbers[f"conveyor_{name}_rms_mm"] = None if belt is None else 1e3 * belt.rms
        numbers[f"conveyor_{name}_max_mm"] = None if belt is None else 1e3 * belt.max_distance
    stiff, rest, ratios = comparison.stiffness, comparison.resting, comparison.ratios
    numbers |= {
        "stiffness_spread_percent": None if stiff is None else 100.0 * stiff.max_deviation,
        "stiffness_moved_deg": None if stiff is None else degrees(float(stiff.moved.max())),
        "learnt_error_ratio": comparison.learnt,
        "rest_moved_deg": None if rest is None else degrees(rest.moved),
        "rest_air_saved_percent": None if rest is None else 100.0 * (1.0 - rest.air),
        "bound_median_s": _finite_or_none(float(np.median(comparison.bounds))) if comparison.bounds.size else None,
        "bound_ratio_median": _finite_or_none(float(np.median(ratios))) if ratios.size else None,
        "bound_ratio_95": _finite_or_none(float(np.quantile(ratios, 0.95, method="higher"))) if ratios.size else None,
    }
    for one in comparison.settling:
        if one.law != TRACKING_LABEL and one.case == settling.NOMINAL_CASE:
            numbers[f"{_key(one.law)}_nominal_settling_95_s"] = _finite_or_none(one.late)
    for one in comparison.ablations:
        numbers[f"{_key(one.law)}_robust_settling_95_s"] = _finite_or_none(one.late)
    return numbers


def _key(law: str) -> str:
    return law.replace("the paper's", "papers").replace(", ", "_").replace(" ", "_")


def _finite_or_none(value: float) -> Number:
    """Return a number that JSON can hold; None for one that is not finite."""
    return value if isfinite(value) else None


def write_numbers(comparison: Comparison, path: Path) -> Path:
    """Write beyond.json, and return its path (OutputError: it can't be written)."""
    return write_text(path, json.dumps(result_numbers(comparison), indent=2, allow_nan=False) + "\n")


def write_page(comparison: Comparison, path: Path) -> Path:
    """Write the page, and return its path (OutputError: it can't be written)."""
    html = render_page(
        "layflat.experiments.beyond",
        "beyond.html.j2",
        machine=comparison.machine.title,
        version=__version__,
        robust=ROBUST_SET_TEXT,
        postures=CONFIGURATION_COUNT,
        heaviest=f"{max_payload(comparison.machine):g}",
        columns=COLUMNS,
        rows=settling_rows(comparison.settling),
        ablations=settling_rows(comparison.ablations),
        numbers=result_numbers(comparison),
        belts=[
            [one.law, f"{one.speed:g}", f"{1e3 * one.rms:.2f}", f"{1e3 * one.max_distance:.2f}"]
            for one in comparison.following
        ],
        figures=list(_draw_figures(comparison)),
    )
    return write_text(path, html)


def _draw_figures(comparison: Comparison) -> Iterator[CaptionedFigure]:
    """Yield the captioned figures of a comparison: settled fractions of three cases, and the ablations."""
    for name, case in (
        ("nominal", settling.NOMINAL_CASE),
        ("robust", settling.ROBUST_CASE),
        ("both", settling.ROBUST_PAYLOAD_CASE),
    ):
        shares = {one.law: one.times for one in comparison.settling if one.case == case}
        caption = "How many of all steps of 40 deg have the tip within 2 mm of its goal for good, by time."
        if case == settling.NOMINAL_CASE and comparison.bounds.size == CONFIGURATION_COUNT:
            shares["openings found offline"] = comparison.bounds
            caption += " Openings that are found offline know all of the plant, and meet no noise."
        yield CaptionedFigure(
            name, f"Steps: {case}.", caption, to_svg(settled_fraction_figure(shares, None, SETTLING_WINDOW))
        )
    if comparison.ablations:
        yield CaptionedFigure(
            "ablation", "What each part of the law is for.", ABLATION_CAPTION, to_svg(_draw_ablations(comparison))
        )


def _draw_ablations(comparison: Comparison) -> Figure:
    """Draw the time (s) in which 95 % settle, cut to `SETTLING_WINDOW`, for the whole law and without each part."""
    whole = comparison.settling_of(TRACKING_LABEL, settling.ROBUST_CASE)
    reference = [] if whole is None else [whole]
    names = [*("all of it" for _ in reference), *(one.law.removeprefix("tracking, ") for one in comparison.ablations)]
    late = [min(one.late, SETTLING_WINDOW) for one in [*reference, *comparison.ablations]]
    with styled_figure(height=3.4, beside=1.1) as (fig, (axes,)):
        draw_bars(axes, names, late, kinds=[*(0 for _ in reference), *(1 for _ in comparison.ablations)], form="{:.2f}")
        axes.set_xlabel("Time within which 95 % settle (s)")
        axes.set_xlim(0.0, 1.1 * SETTLING_WINDOW)
    return fig
