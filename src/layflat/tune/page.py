"""Report of a tuning as a self-contained page."""

from pathlib import Path

from layflat._version import __version__
from layflat.description.tables import Provenance
from layflat.files import write_text
from layflat.machine import Machine
from layflat.plot import CaptionedFigure, render_page
from layflat.plot.style import to_svg
from layflat.plot.tuning import cost_figure, settled_fraction_figure
from layflat.tune.knobs import current_values
from layflat.tune.robust import SETTLING_LIMIT, coupling_warnings, validation_conditions
from layflat.tune.tuned import Row, TunedController
from layflat.tune.tuning import Tuning


def write_page(result: TunedController, path: Path) -> Path:
    """Write the HTML page of a finished tuning, and return its path; raise OutputError if that fails."""
    tuning = result.tuning
    by = validation_conditions(tuning.make_conditions)
    html = render_page(
        "layflat.tune",
        "tuning.html.j2",
        machine=tuning.base.name,
        title=tuning.base.title,
        version=__version__,
        command=tuning.command,
        generations=len(tuning.history) - 1,
        seconds=f"{tuning.seconds:.1f}",
        kept=tuning.unchanged,
        file=tuning.path.name,
        values=tuning.law.values,
        within=by.measure.within,
        figures=result.comparison_rows(),
        statement=by.measure.statement,
        warnings=coupling_warnings(result.before, result.after),
        runs=by.runs,
        nominal=by.nominal,
        spread=tuning.law.spread(by, tuning.machine),
        usual=f"{tuning.machine.arm.payload:g}",
        drawn=_draw_figures(result),
        found=value_rows(tuning, result.machine),
    )
    return write_text(path, html)


def value_rows(tuning: Tuning, tuned: Machine) -> list[Row]:
    """Return a row for every tuned value: its path, value and source before, value and source after.

    A value that the machine had not is "none", with an empty source.
    """

    def source(machine: Machine, path: str) -> str:
        """Return the source of a value with its note; "default" for a value that no file sets."""
        provenance = machine.provenance.get(path, Provenance("default"))
        return f"{provenance.source}: {provenance.note}" if provenance.note else provenance.source

    rows, now = [], current_values(tuning.machine, tuning.knobs)
    for knob, was, found in zip(tuning.knobs, now, current_values(tuned, tuning.knobs), strict=True):
        path = knob.paths[0]
        there = tuning.was_complete or path in tuning.base.provenance
        old = [str(knob.text(was)), source(tuning.base, path)] if there else ["none", ""]
        rows.append([path, *old, str(knob.text(found)), source(tuned, path)])
    return rows


def _draw_figures(result: TunedController) -> list[CaptionedFigure]:
    """Return the captioned figures of a tuning: responses, settled fractions and cost."""
    tuning, runs = result.tuning, len(result.after.settling)
    settled = {label: one.settling for label, one in result.validations.items()}
    return [
        CaptionedFigure(
            "responses",
            "Steps under nominal conditions.",
            "Each joint's angle, and below it the error enlarged; settled within the grey band.",
            to_svg(result.draw_responses()),
        ),
        CaptionedFigure(
            "settled",
            "How soon moves settle.",
            f"Share of moves that have settled, over all {runs} runs; the line stands at {SETTLING_LIMIT:g} s.",
            to_svg(
                settled_fraction_figure(settled, SETTLING_LIMIT, validation_conditions(tuning.make_conditions).window)
            ),
        ),
        CaptionedFigure(
            "cost",
            "The search.",
            "Cost of the best so far, by a panel of conditions that stays the same.",
            to_svg(cost_figure([found.cost for found in tuning.history], tuning.round_starts)),
        ),
    ]
