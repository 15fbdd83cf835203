"""The report's figures; their titles, captions and order stand in figures.toml."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from layflat.experiments.axis_one import AT, SCAN
from layflat.experiments.claim import texts_of
from layflat.experiments.open_loop import RIG_PRESSURE
from layflat.experiments.reproduction import Reproduction
from layflat.plot.cam import cam_procedure
from layflat.plot.curves import average_response, settling_over_inertia, valve_sweeps
from layflat.plot.hysteresis import hysteresis_curves
from layflat.plot.page import Drawn
from layflat.plot.runs import angles, arm_steps
from layflat.plot.style import to_svg
from layflat.sim.metrics import BAND

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figures(found: Reproduction) -> Iterator[Drawn]:
    """Draw the figures whose claims were evaluated, one by one."""
    evaluated = {claim.id for claim in found.claims if claim.quantities}
    for name, texts in FIGURES.items():
        if evaluated.issuperset(texts["claims"]):
            yield Drawn(name, texts["title"], texts["caption"], to_svg(DRAWN[name](found)))


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
    part = {label: run.sel(time=slice(0, AT + 4)) for label, run in runs.items()}
    return angles(part, "small", since=AT, band=BAND)


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
        {"new joint with brake": found.axis_one.times_braked, "earlier actuator": found.axis_one.times_earlier}, SCAN
    ),
    "fig-14": lambda found: arm_steps(found.two_axis.steps, band=BAND),
    "fig-valve": _valve,
    "fig-average": lambda found: average_response(found.dither.frequency, found.dither.response, 50.0),
}

FIGURES = texts_of("figures.toml")
"""Title, caption and claims shown of each figure by its id, in the order of the paper's."""
