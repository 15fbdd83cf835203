"""Tuned controllers: the machine with better values, and their results."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layflat.machine import Machine
from layflat.motion.path import half_strokes
from layflat.plot.tables import html_table
from layflat.sim.metrics import SETTLING_BAND
from layflat.tune.conditions import REST_TIME, nominal_configurations
from layflat.tune.robust import SETTLING_LIMIT, Validation, validate, validation_conditions
from layflat.tune.tuning import Progress, Tuning, begin_tuning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = list[str]


@dataclass(frozen=True)
class TunedController:
    """Result of a tuning."""

    tuning: Tuning  # finished
    machine: Machine  # with the tuned values
    before: Validation | None  # results before the tuning; None where the machine had no complete values
    after: Validation  # results after it

    @property
    def path(self) -> Path:
        """File with the description of the machine."""
        return self.tuning.path

    @property
    def columns(self) -> Row:
        """Heads of `comparison_rows`."""
        within = validation_conditions(self.tuning.make_conditions).measure.within
        return [f"settling within {within}, coupling", "before", "after"]

    def comparison_rows(self) -> list[Row]:
        """Return the rows of the comparison as texts: name, before ("none" if there was no result), after."""
        by, machine = validation_conditions(self.tuning.make_conditions), self.tuning.machine

        def figures(of: Validation) -> dict[str, str]:
            """Return the texts of a validation by the names of the rows."""
            moves = {
                f"{machine.arm.payload:g} kg: {m}": s
                for m, s in zip(describe_nominal_moves(machine), of.nominal, strict=True)
            }
            return {
                **{f"nominal, {move}": _seconds(seconds) for move, seconds in moves.items()},
                **{f"nominal: {what}": f"{np.degrees(far):.2g} deg" for what, far in of.deflections.items()},
                f"worst over {by.runs} runs": _seconds(of.worst),
                f"moves not settled in {SETTLING_LIMIT:g} s": f"{of.late} of {of.settling.size}",
                "cost": _seconds(of.cost),
            }

        was = {} if self.before is None else figures(self.before)
        return [[name, was.get(name, "none"), now] for name, now in figures(self.after).items()]

    @property
    def validations(self) -> dict[str, Validation]:
        """Results before, if there are any, and after."""
        return ({} if self.before is None else {"before": self.before}) | {"after": self.after}

    def draw_responses(self) -> "Figure":
        """Draw the steps of each joint under nominal conditions, before and after, with their errors enlarged."""
        from layflat.plot.tuning import response_figure  # noqa: PLC0415  # matplotlib takes long to import

        runs = {label: one.response for label, one in self.validations.items()}
        return response_figure(runs, band=SETTLING_BAND, since=REST_TIME)

    def plot(self) -> "Figure":
        """Draw the steps of each joint under nominal conditions, before and after, with a caption."""
        from layflat.plot.style import add_caption  # noqa: PLC0415  # matplotlib takes long to import

        caption = f"{self.machine.name}: steps under nominal conditions; settled within the grey band"
        return add_caption(self.draw_responses(), caption)

    def _repr_html_(self) -> str:
        return html_table(self.machine.name, self.columns, self.comparison_rows())


def tune_controller(
    machine: str | Path,
    *,
    out: str | Path = "build/tune",
    method: str = "global",
    start: str = "neutral",
    seed: int = 1,
    generations: int | None = None,
    over: str = "",
    device: str = "cpu",
    progress: Progress = lambda *_: None,
) -> TunedController:
    """Search for better gains or settings of a machine's controller, and write the description that has them.

    Ctrl-C ends the search; the best so far is kept.

    Args:
        machine: built-in name or file; `save` writes one of a machine that was changed in Python.
        out: folder for the description, NAME-tuned.toml.
        method: "global" for all values at once, "phases" for the paper's gains joint by joint and phase by phase.
        start: "neutral" for values that do not depend on the machine, or "current" for its own.
        seed: seed of the search; the same seed gives the same values.
        generations: number in all; default: as many as the method needs.
        over: "cloud" for conditions with the values of every member of the machine's cloud; default: its own.
        device: device for the runs, "cpu" or "cuda".
        progress: called with the best so far, the generations done, and the name of the part.

    Raises:
        MachineError: the machine is wrong, or has no controller that can be tuned.
        InputError: an argument is wrong, or the extra `tune` is not installed.
        OutputError: the folder can't be written to.
    """
    tuning = begin_tuning(
        machine, Path(out), method=method, start=start, seed=seed, generations=generations, over=over, device=device
    )
    tuning.search(progress)
    return finish_tuning(tuning)


def finish_tuning(tuning: Tuning) -> TunedController:
    """Write the description with the best values of a search, and evaluate the machine before and after."""
    tuned = tuning.save_best()
    before = validate(tuning.base, tuning.make_conditions) if tuning.was_complete else None
    return TunedController(tuning, tuned, before, validate(tuned, tuning.make_conditions))


def describe_nominal_moves(machine: Machine) -> list[str]:
    """Return the joints and angles of each move under nominal conditions, in words."""
    halves = half_strokes(machine)
    moved = np.degrees(np.diff(nominal_configurations(len(halves)), axis=0) * halves)
    return [
        " and ".join(f"{name} joint by {by:.3g} deg" for name, by in zip(machine.joints, step, strict=True) if by)
        for step in moved
    ]


def _seconds(value: float) -> str:
    return f"{value:.2f} s" if isfinite(value) else "not settled"
