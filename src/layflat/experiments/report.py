"""Results of a reproduction on disk: claims.json, and one self-contained report.html with its figures.

Another process evaluates some claims and draws their figures while the command's own does the rest (`perform`).
"""

import json
from collections.abc import Callable, Iterator, Sequence
from math import isfinite
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from layflat._version import __version__
from layflat.experiments.axis_one import AT, DURATION, TWICE, WINDOWS
from layflat.experiments.bench import bench
from layflat.experiments.claim import Claim, texts_of
from layflat.experiments.open_loop import RIG_PRESSURE
from layflat.experiments.questions import Answer
from layflat.experiments.reproduction import Reproduction
from layflat.files import write_text
from layflat.machine.listing import Line
from layflat.plot.curves import (
    average_response,
    cam_procedure,
    hysteresis_curves,
    ratio_over_window,
    settling_over_inertia,
    valve_sweeps,
)
from layflat.plot.page import Drawn, page
from layflat.plot.runs import angles, arm_steps
from layflat.plot.style import to_svg
from layflat.sim.metrics import BAND

TINY, LARGE = 1e-4, 1e5  # numbers below and above these are not written out


def number(value: float) -> str:
    """Return a number as people read it; a time that is not finite is one that never comes."""
    if not isfinite(value):
        return "never"
    if abs(value) >= LARGE:
        return f"{value:,.0f}"
    return f"< {TINY:g}" if 0.0 < value < TINY else f"{value:.5g}"


AGREES = {True: "yes", False: "NO", None: "-"}
COLUMNS = ("claim", "quantity", "the paper", "simulated", "unit", "agrees")


def table(claims: Sequence[Claim]) -> list[list[str]]:
    """Return rows with `COLUMNS`: one for each quantity, or for the reason why a claim was not evaluated."""
    rows = []
    for one in claims:
        told = [[q.name, q.paper, number(q.value), q.unit.removeprefix("1")] for q in one.quantities]
        for i, cells in enumerate(told or [[one.reason, "", "", ""]]):
            rows.append(["" if i else one.id, *cells, "" if i else AGREES[one.agrees]])
    return rows


def write_claims(found: Reproduction, path: Path) -> Path:
    """Write the claims as a JSON list (OutputError: it can't be written there)."""
    records = [claim.record() for claim in found.claims]
    return write_text(path, json.dumps(records, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def write_report(found: Reproduction, assumed: list[Line], path: Path, answers: Sequence[Answer] = ()) -> Path:
    """Write the report as one HTML file that needs nothing else (OutputError: it can't be written there).

    `assumed` has the lines of the description that the paper does not give, `answers` those to open questions, if any.
    """
    html = page(
        "layflat.experiments",
        "report.html.j2",
        machine=found.bench.arm.title,
        version=__version__,
        summary=found.summary,
        claims=found.claims,
        number=number,
        figures=list(figures(found)),
        assumed=assumed,
        answers=list(answers),
    )
    return write_text(path, html)


def figures(found: Reproduction) -> Iterator[Drawn]:
    """Draw the figures whose claims were evaluated, one by one; those that are drawn already are taken as they are."""
    evaluated = {claim.id for claim in found.claims if claim.quantities}
    for name, texts in FIGURES.items():
        if evaluated.issuperset(texts["claims"]):
            yield found.drawn.get(name) or Drawn(name, texts["title"], texts["caption"], to_svg(DRAWN[name](found)))


def _rigs(**labels: str) -> Callable[[Reproduction], Figure]:
    def draw(found: Reproduction) -> Figure:
        named = {label.replace("_", " "): name for label, name in labels.items()}
        return hysteresis_curves({label: found.open_loop.rigs[name][RIG_PRESSURE] for label, name in named.items()})

    return draw


def _steps(found: Reproduction) -> Figure:
    runs = {
        "with brake": found.axis_one.braked,
        "without brake": found.axis_one.unbraked,
        "earlier actuator": found.axis_one.earlier,
    }
    part = {label: run.sel(time=slice(0, AT + WINDOWS[-1])) for label, run in runs.items()}
    return angles(part, "small", since=AT, band=BAND)


def _ratio(found: Reproduction) -> Figure:
    new, earlier = found.axis_one.carried_braked, found.axis_one.carried_earlier
    window = np.linspace(WINDOWS[0], WINDOWS[-1], 131)
    limits = np.array([(new.within(allowed), earlier.within(allowed)) for allowed in window])
    ratio = limits[:, 0] / np.where(limits[:, 1] > 0.0, limits[:, 1], np.nan)
    return ratio_over_window(window, ratio, new.stable / earlier.stable if earlier.stable else np.nan, TWICE)


def _valve(found: Reproduction) -> Figure:
    labels = {"without": "without dither", "normal": "with 50 Hz dither", "fast": "with 400 Hz dither"}
    sweeps = {labels[name]: sweep for name, sweep in found.dither.sweeps.items()}
    return valve_sweeps({k: ((s.command, s.up), (s.command, s.down)) for k, s in sweeps.items()})


DRAWN: dict[str, Callable[[Reproduction], Figure]] = {
    "fig-2": _rigs(single_thickness="rig-single-thickness"),
    "fig-3": _rigs(polyester_webbing="rig-polyester", with_plate="rig-polyester-plate"),
    "fig-4": _rigs(Kevlar_webbing="rig-kevlar", with_plate="rig-kevlar-plate"),
    "fig-5": _rigs(shell_and_steel="rig-shell-steel"),
    "fig-6": lambda found: cam_procedure(found.statics.design.with_cam()),
    "fig-10": lambda found: hysteresis_curves({"new joint": found.open_loop.unbraked}),
    "fig-11": lambda found: hysteresis_curves({"earlier actuator": found.open_loop.earlier}),
    "fig-12": lambda found: hysteresis_curves(
        {"with brake": found.open_loop.braked, "without": found.open_loop.unbraked}
    ),
    "fig-13": _steps,
    "fig-13b": lambda found: settling_over_inertia(
        {
            "new joint with brake": found.axis_one.carried_braked.times,
            "earlier actuator": found.axis_one.carried_earlier.times,
        },
        DURATION,
    ),
    "fig-13c": _ratio,
    "fig-14": lambda found: arm_steps(found.two_axis.steps, band=BAND),
    "fig-valve": _valve,
    "fig-average": lambda found: average_response(found.dither.frequency, found.dither.response, 50.0),
}

FIGURES = texts_of("figures.toml")
"""Title, caption and claims shown of each figure by its id, in the order of the paper's."""


def perform(machine: str) -> Iterator[Claim | Drawn]:
    """Evaluate the claims of a machine that another process does not, then draw their figures, one by one."""
    found = Reproduction.on(bench(machine))
    for rule, experiment in found.rules(aside=True):
        found.claims.append(rule.evaluated(experiment))
        yield found.claims[-1]
    yield from figures(found)
