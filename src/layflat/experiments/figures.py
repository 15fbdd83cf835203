"""The report's figures, in the order of the paper's, each with a caption that says what to see."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from layflat.experiments.axis_one import AT, SCAN
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
    for number, (title, caption, claims, draw) in FIGURES.items():
        if evaluated.issuperset(claims):
            yield Drawn(number, title, caption, to_svg(draw(found)))


def _rigs(**labels: str) -> Callable[[Reproduction], Figure]:
    def draw(found: Reproduction) -> Figure:
        named = {label.replace("_", " "): name for label, name in labels.items()}
        return hysteresis_curves({label: found.open_loop.rigs[name][RIG_PRESSURE] for label, name in named.items()})

    return draw


def _valve(found: Reproduction) -> Figure:
    labels = {"without": "without dither", "normal": "with 50 Hz dither", "fast": "with 400 Hz dither"}
    sweeps = {labels[name]: sweep for name, sweep in found.dither.sweeps.items()}
    return valve_sweeps({k: ((s.command, s.up), (s.command, s.down)) for k, s in sweeps.items()})


FIGURES: dict[str, tuple[str, str, tuple[str, ...], Callable[[Reproduction], Figure]]] = {
    "fig-2": (
        "Fig. 2. Single thickness of hose, polyester webbing, 3 bar.",
        "Folding the hose or not makes no difference: compare the hysteresis curve with that of Fig. 3.",
        ("rig-variants",),
        _rigs(single_thickness="rig-single-thickness"),
    ),
    "fig-3": (
        "Fig. 3. Polyester webbing, with and without an aluminium plate, 3 bar.",
        "The plate keeps the hose's outer surface flat: the hysteresis curve is a little less high.",
        ("rig-variants",),
        _rigs(polyester_webbing="rig-polyester", with_plate="rig-polyester-plate"),
    ),
    "fig-4": (
        "Fig. 4. Kevlar webbing, with and without an aluminium plate, 3 bar.",
        "Marginally better than polyester, and again better with the plate.",
        ("rig-variants",),
        _rigs(Kevlar_webbing="rig-kevlar", with_plate="rig-kevlar-plate"),
    ),
    "fig-5": (
        "Fig. 5. Rigid shell and 0.1 mm steel strap, 3 bar.",
        "The thinnest curve of all rigs: the shell limits the hose's distortion, the strap has no inner friction.",
        ("rig-variants",),
        _rigs(shell_and_steel="rig-shell-steel"),
    ),
    "fig-6": (
        "Fig. 6. The large joint's cam.",
        "Each thin line is the strap at one position of the shell, seen from the cam; their envelope is the profile. "
        "Where the hose pulls less the line runs further from the axis, so that the torque stays the same.",
        ("constant-torque",),
        lambda found: cam_procedure(found.statics.design.with_cam()),
    ),
    "fig-10": (
        "Fig. 10. Axis one without brake, 4 bar.",
        "With cam, shell and steel strap the torque stays nearly constant and the curve is thin.",
        ("open-loop-hysteresis",),
        lambda found: hysteresis_curves({"new joint": found.open_loop.unbraked}),
    ),
    "fig-11": (
        "Fig. 11. The earlier actuator, 4 bar.",
        "Torque falls along the stroke; the curve is high but rounded: after each reversal torque changes gradually.",
        ("open-loop-hysteresis",),
        lambda found: hysteresis_curves({"earlier actuator": found.open_loop.earlier}),
    ),
    "fig-12": (
        "Fig. 12. Axis one with its brake, 4 bar.",
        "As much hysteresis as the earlier actuator's, but with upright sides: small motions meet the full force.",
        ("open-loop-hysteresis",),
        lambda found: hysteresis_curves({"with brake": found.open_loop.braked, "without": found.open_loop.unbraked}),
    ),
    "fig-13": (
        "Fig. 13. Axis one: a 40 deg step with 2 kg at 0.4 m.",
        "With the brake the joint settles; without it, it goes on oscillating; the earlier actuator lies between.",
        ("unbraked-joint", "braked-joint"),
        lambda found: angles(
            {
                "with brake": found.axis_one.braked.sel(time=slice(0, AT + 4)),
                "without brake": found.axis_one.unbraked.sel(time=slice(0, AT + 4)),
                "earlier actuator": found.axis_one.earlier.sel(time=slice(0, AT + 4)),
            },
            "small",
            since=AT,
            band=BAND,
        ),
    ),
    "fig-13b": (
        "How much inertia can be carried.",
        "Time to settle after a 40 deg step against inertia per torque; crosses stand for joints that do not settle.",
        ("braked-joint",),
        lambda found: settling_over_inertia(
            {
                "new joint with brake": found.axis_one.times_braked,
                "earlier actuator": found.axis_one.times_earlier,
            },
            SCAN,
        ),
    ),
    "fig-14": (
        "Fig. 14. The two-axis arm with 1.5 kg: a 40 deg step of each axis in turn.",
        "The large joint's step pushes the small one off its place; the reverse hardly shows. Both return to demand.",
        ("two-axis-settling",),
        lambda found: arm_steps(found.two_axis.steps, band=BAND),
    ),
    "fig-valve": (
        "What dither is for.",
        "Without dither the spool sticks: it follows the command late on either way. At 50 Hz the two ways agree; "
        "one too fast for the spool leaves it sticking, then letting go.",
        ("dither-need",),
        _valve,
    ),
    "fig-average": (
        "What averaging is for.",
        "The mean over four cycles has a zero at the dither's frequency.",
        ("averaging",),
        lambda found: average_response(found.dither.frequency, found.dither.response, 50.0),
    ),
}
"""Title, caption, claims shown and drawing of each figure by its id."""
