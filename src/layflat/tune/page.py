"""Report of a tuning: figures in a table, and one page that needs nothing else."""

from math import isfinite
from pathlib import Path

import numpy as np

from layflat._version import __version__
from layflat.description.provenance import Provenance
from layflat.files import write_text
from layflat.machine import Machine
from layflat.plot.page import Drawn, page
from layflat.plot.style import to_svg
from layflat.plot.tuning import cost_history, responses, settled_shares
from layflat.sim.metrics import BAND
from layflat.tune.conditions import REST, nominal_postures
from layflat.tune.knobs import values_of
from layflat.tune.robust import LIMIT, Validation, fresh, warnings
from layflat.tune.tuning import Tuning

Row = list[str]


def figures_of(tuning: Tuning, before: Validation | None, after: Validation) -> list[Row]:
    """Return what is compared: its name, before, after."""
    by, machine = fresh(tuning.meet), tuning.machine

    def figures(of: Validation) -> dict[str, str]:
        moves = {f"{machine.arm.payload:g} kg: {m}": s for m, s in zip(nominal_moves(machine), of.nominal, strict=True)}
        return {
            **{f"nominal, {move}": _seconds(seconds) for move, seconds in moves.items()},
            **{f"nominal: {what}": f"{np.degrees(far):.2g} deg" for what, far in of.pushed.items()},
            f"worst over {by.runs} runs": _seconds(of.worst),
            f"moves not settled in {LIMIT:g} s": f"{of.late} of {of.settling.size}",
            "cost": _seconds(of.cost),
        }

    was = {} if before is None else figures(before)
    return [[name, was.get(name, "none"), now] for name, now in figures(after).items()]


def nominal_moves(machine: Machine) -> list[str]:
    """Return what is moved under nominal conditions, and how far, in words."""
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    moved = np.degrees(np.diff(nominal_postures(len(halves)), axis=0) * halves)
    return [
        " and ".join(f"{name} joint by {by:.3g} deg" for name, by in zip(machine.joints, step, strict=True) if by)
        for step in moved
    ]


def write_page(tuning: Tuning, tuned: Machine, before: Validation | None, after: Validation, path: Path) -> Path:
    """Write the page (OutputError: it can't be written there)."""
    by = fresh(tuning.meet)
    html = page(
        "layflat.tune",
        "tuning.html.j2",
        machine=tuning.base.name,
        title=tuning.base.title,
        version=__version__,
        command=tuning.command,
        generations=len(tuning.history) - 1,
        seconds=f"{tuning.seconds:.1f}",
        kept=tuning.kept,
        file=tuning.path.name,
        values=tuning.law.values,
        within=by.measure.within,
        figures=figures_of(tuning, before, after),
        statement=by.measure.statement,
        warnings=warnings(before, after),
        runs=by.runs,
        nominal=by.nominal,
        spread=tuning.law.spread(by, tuning.machine),
        usual=f"{tuning.machine.arm.payload:g}",
        drawn=_drawn(tuning, before, after),
        found=values_table(tuning, tuned),
    )
    return write_text(path, html)


def values_table(tuning: Tuning, tuned: Machine) -> list[Row]:
    """Return every value that was tuned: its path, and its value and source before and after."""

    def source(machine: Machine, path: str) -> str:
        known = machine.provenance.get(path, Provenance("default"))
        return f"{known.source}: {known.note}" if known.note else known.source

    rows, now = [], values_of(tuning.machine, tuning.knobs)
    for knob, was, found in zip(tuning.knobs, now, values_of(tuned, tuning.knobs), strict=True):
        path = knob.paths[0]
        there = tuning.was_complete or path in tuning.base.provenance
        old = [str(knob.text(was)), source(tuning.base, path)] if there else ["none", ""]
        rows.append([path, *old, str(knob.text(found)), source(tuned, path)])
    return rows


def _drawn(tuning: Tuning, before: Validation | None, after: Validation) -> list[Drawn]:
    shown = {label: one for label, one in (("before", before), ("after", after)) if one is not None}
    runs = {label: one.response for label, one in shown.items()}
    settled = {label: one.settling for label, one in shown.items()}
    return [
        Drawn(
            "responses",
            "Steps under nominal conditions.",
            "Each joint's angle, and below it the error enlarged; settled within the grey band.",
            to_svg(responses(runs, band=BAND, since=REST)),
        ),
        Drawn(
            "settled",
            "How soon moves settle.",
            f"Share of moves that have settled, over all {len(after.settling)} runs; the line stands at {LIMIT:g} s.",
            to_svg(settled_shares(settled, LIMIT, fresh(tuning.meet).window)),
        ),
        Drawn(
            "cost",
            "The search.",
            "Cost of the best so far, by a panel of conditions that stays the same.",
            to_svg(cost_history([found.cost for found in tuning.history], tuning.begun)),
        ),
    ]


def _seconds(value: float) -> str:
    return f"{value:.2f} s" if isfinite(value) else "not settled"
