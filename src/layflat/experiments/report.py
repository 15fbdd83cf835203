"""Results of a reproduction on disk: claims.json, and one self-contained report.html with its figures.

Another process evaluates some claims and draws their figures meanwhile (`evaluate_other_claims`).
"""

import json
from collections.abc import Callable, Iterator, Sequence
from math import isfinite
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from layflat._version import __version__
from layflat.experiments.axis_one import ABOUT_TWICE, DURATION, SETTLING_LIMITS, STEP_TIME
from layflat.experiments.bench import load_bench
from layflat.experiments.claim import Claim, read_texts
from layflat.experiments.open_loop import RIG_PRESSURE
from layflat.experiments.questions import Answer
from layflat.experiments.reproduction import Reproduction
from layflat.files import write_text
from layflat.machine.listing import ListedValue
from layflat.plot import CaptionedFigure, render_page
from layflat.plot.curves import (
    cam_procedure,
    hysteresis_curves,
    moving_average_gain,
    ratio_over_window,
    settling_over_inertia,
    valve_sweeps,
)
from layflat.plot.runs import angle_figure, arm_steps
from layflat.plot.style import to_svg
from layflat.sim.metrics import SETTLING_BAND

MIN_PRINTED, MAX_PRINTED = 1e-4, 1e5  # below: "< 0.0001"; from here on: without decimals


def format_number(value: float) -> str:
    """Return a number as text of five significant digits, or without decimals from `MAX_PRINTED` on.

    It is "never" if not finite, "< 0.0001" if positive and that small.
    """
    if not isfinite(value):
        return "never"
    if abs(value) >= MAX_PRINTED:
        return f"{value:,.0f}"
    return f"< {MIN_PRINTED:g}" if 0.0 < value < MIN_PRINTED else f"{value:.5g}"


AGREEMENT_TEXTS = {True: "yes", False: "NO", None: "-"}
COLUMNS = ("claim", "quantity", "the paper", "simulated", "unit", "agrees")


def claim_rows(claims: Sequence[Claim]) -> list[list[str]]:
    """Return table rows by `COLUMNS`: one for each quantity, or for the reason why a claim was not evaluated.

    Only the first row of a claim has its id, and whether it agrees.
    """
    rows = []
    for claim in claims:
        quantity_cells = [[q.name, q.paper, format_number(q.value), q.unit.removeprefix("1")] for q in claim.quantities]
        for i, cells in enumerate(quantity_cells or [[claim.reason, "", "", ""]]):
            rows.append(["" if i else claim.id, *cells, "" if i else AGREEMENT_TEXTS[claim.agrees]])
    return rows


def write_claims(reproduction: Reproduction, path: Path) -> Path:
    """Write the claims as a JSON list, and return the path; raise OutputError if it can't be written there."""
    records = [claim.record() for claim in reproduction.claims]
    return write_text(path, json.dumps(records, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def write_report(
    reproduction: Reproduction, assumed: list[ListedValue], path: Path, answers: Sequence[Answer] = ()
) -> Path:
    """Write the report as one self-contained HTML file, and return its path.

    Args:
        reproduction: evaluated claims and the experiments behind them.
        assumed: lines of the description whose values the paper does not give.
        path: path of the file.
        answers: answers to open questions.

    Raises:
        OutputError: the file can't be written.
    """
    html = render_page(
        "layflat.experiments",
        "report.html.j2",
        machine=reproduction.bench.arm.title,
        version=__version__,
        summary=reproduction.summary,
        claims=reproduction.claims,
        number=format_number,
        figures=list(draw_figures(reproduction)),
        assumed=assumed,
        answers=list(answers),
    )
    return write_text(path, html)


def draw_figures(reproduction: Reproduction) -> Iterator[CaptionedFigure]:
    """Yield the figures whose claims were all evaluated: from `reproduction.drawn`, or else drawn now."""
    evaluated = {claim.id for claim in reproduction.claims if claim.quantities}
    for name, texts in FIGURE_TEXTS.items():
        if evaluated.issuperset(texts["claims"]):
            yield reproduction.drawn.get(name) or CaptionedFigure(
                name, texts["title"], texts["caption"], to_svg(FIGURE_DRAWERS[name](reproduction))
            )


def _rig_drawer(**labels: str) -> Callable[[Reproduction], Figure]:
    """Return a function that draws the hysteresis curves of rigs, given by label, in which "_" stands for a space."""

    def draw(reproduction: Reproduction) -> Figure:
        """Draw the curves of these rigs at `RIG_PRESSURE`."""
        named = {label.replace("_", " "): name for label, name in labels.items()}
        return hysteresis_curves(
            {label: reproduction.open_loop.rigs[name][RIG_PRESSURE] for label, name in named.items()}
        )

    return draw


def _draw_steps(reproduction: Reproduction) -> Figure:
    """Draw the small joint's angle over a step, with and without brake, and of the earlier actuator."""
    runs = {
        "with brake": reproduction.axis_one.braked,
        "without brake": reproduction.axis_one.unbraked,
        "earlier actuator": reproduction.axis_one.earlier,
    }
    part = {label: run.sel(time=slice(0, STEP_TIME + SETTLING_LIMITS[-1])) for label, run in runs.items()}
    return angle_figure(part, "small", since=STEP_TIME, band=SETTLING_BAND)


def _draw_ratio(reproduction: Reproduction) -> Figure:
    """Draw the ratio of the inertias that new and earlier actuator carry, over the allowed settling time (s)."""
    new, earlier = reproduction.axis_one.carried_braked, reproduction.axis_one.carried_earlier
    window = np.linspace(SETTLING_LIMITS[0], SETTLING_LIMITS[-1], 131)
    limits = np.array([(new.max_inertia_within(allowed), earlier.max_inertia_within(allowed)) for allowed in window])
    ratio = limits[:, 0] / np.where(limits[:, 1] > 0.0, limits[:, 1], np.nan)
    return ratio_over_window(window, ratio, new.stable / earlier.stable if earlier.stable else np.nan, ABOUT_TWICE)


def _draw_valve_sweeps(reproduction: Reproduction) -> Figure:
    """Draw the opening over the command, swept up and down, for each dither."""
    labels = {"without": "without dither", "normal": "with 50 Hz dither", "fast": "with 400 Hz dither"}
    sweeps = {labels[name]: sweep for name, sweep in reproduction.dither.sweeps.items()}
    return valve_sweeps({k: ((s.command, s.up), (s.command, s.down)) for k, s in sweeps.items()})


FIGURE_DRAWERS: dict[str, Callable[[Reproduction], Figure]] = {
    "fig-2": _rig_drawer(single_thickness="rig-single-thickness"),
    "fig-3": _rig_drawer(polyester_webbing="rig-polyester", with_plate="rig-polyester-plate"),
    "fig-4": _rig_drawer(Kevlar_webbing="rig-kevlar", with_plate="rig-kevlar-plate"),
    "fig-5": _rig_drawer(shell_and_steel="rig-shell-steel"),
    "fig-6": lambda result: cam_procedure(result.statics.design.with_cam()),
    "fig-10": lambda result: hysteresis_curves({"new joint": result.open_loop.unbraked}),
    "fig-11": lambda result: hysteresis_curves({"earlier actuator": result.open_loop.earlier}),
    "fig-12": lambda result: hysteresis_curves(
        {"with brake": result.open_loop.braked, "without": result.open_loop.unbraked}
    ),
    "fig-13": _draw_steps,
    "fig-13b": lambda result: settling_over_inertia(
        {
            "new joint with brake": result.axis_one.carried_braked.times,
            "earlier actuator": result.axis_one.carried_earlier.times,
        },
        DURATION,
    ),
    "fig-13c": _draw_ratio,
    "fig-14": lambda result: arm_steps(result.two_axis.steps, band=SETTLING_BAND),
    "fig-valve": _draw_valve_sweeps,
    "fig-average": lambda result: moving_average_gain(result.dither.frequency, result.dither.response, 50.0),
}

FIGURE_TEXTS = read_texts("figures.toml")
"""Title, caption and required claims of each figure by its id, in the order of the paper."""


def evaluate_other_claims(machine: str) -> Iterator[Claim | CaptionedFigure]:
    """Yield the claims of a machine that the subprocess of a reproduction evaluates, then their figures."""
    reproduction = Reproduction.from_bench(load_bench(machine))
    for rule, experiment in reproduction.rules(in_subprocess=True):
        reproduction.claims.append(rule.evaluate_claim(experiment))
        yield reproduction.claims[-1]
    yield from draw_figures(reproduction)
