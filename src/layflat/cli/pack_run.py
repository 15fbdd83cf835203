"""Parts that commands which pack share: a calibration, a run, and what is printed and written of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from layflat.cli.app import counted, print_table
from layflat.cli.bars import steps_bar
from layflat.cli.rig import FAULT
from layflat.errors import InputError, LayflatError, NoDrawingError, StoppedError

if TYPE_CHECKING:
    from layflat.cell.file.model import Cell
    from layflat.cell.vision import Calibration
    from layflat.cell.work.observer import Observer
    from layflat.cell.work.records import Delivery
    from layflat.cell.work.run import Run


RESULTS, CALIBRATION, SHEET = "results.json", "calibration.toml", "sheet.png"


@dataclass(frozen=True)
class Asked:
    """Request of a run of a cell."""

    cell: "Cell"
    seed: int
    picks: int
    out: Path
    film: str  # its kind, or "none"

    @property
    def results(self) -> Path:
        """The file of the results."""
        return self.out / RESULTS


def calibration_of(
    cell: "Cell", given: Path | None, out: Path, told: Callable[[float], object] = lambda _: None
) -> "Calibration | None":
    """Return that of the cell's camera, from a file or made anew; say so and return None without OpenGL.

    What is done of a new one, a share, is `told`.
    """
    from layflat.bridge.view.picture import context  # noqa: PLC0415
    from layflat.cell.vision import load_calibration  # noqa: PLC0415
    from layflat.cell.work.run import calibrated  # noqa: PLC0415

    try:
        if given is not None:
            context(16, 16).free()
            return load_calibration(given)
        with steps_bar("calibrating the camera, per cent", 100) as advance:

            def show(share: float) -> None:
                advance(round(100 * share))
                told(share)

            found = calibrated(cell, show)
    except NoDrawingError as error:
        typer.echo(f"layflat: {error}", err=True)
        typer.echo("layflat: continuing without images; the scene's truth stands in for the camera", err=True)
        return None
    typer.echo(f"wrote {found.save(out / CALIBRATION)}")
    return found


def one_run(asked: Asked, calibration: "Calibration | None", *observers: "Observer") -> "tuple[Run, list[Path]]":
    """Return a run, and the film and contact sheet that it wrote where images can be rendered."""
    from layflat.cell.work.film_and_sheet import film_and_sheet  # noqa: PLC0415
    from layflat.cell.work.observer import Observers, PickCounter  # noqa: PLC0415
    from layflat.cell.work.run import packed  # noqa: PLC0415

    cell, seed, picks = asked.cell, asked.seed, asked.picks
    with steps_bar(f"picks in {cell.name!r}", picks) as advance:
        own = PickCounter(advance), *observers
        if calibration is None:
            return packed(cell, seed, picks, calibration, Observers(*own)), []
        path = None if asked.film == "none" else asked.out / f"film.{asked.film}"
        sheet = asked.out / SHEET
        with film_and_sheet(path, sheet, f"{cell.name}, seed {seed}", calibration) as pictures:
            run = packed(cell, seed, picks, calibration, Observers(*own, pictures))
        return run, [sheet] if path is None else [path, sheet]


def error_of(asked: Asked, run: "Run") -> LayflatError | None:
    """Return what ended a run early, with where its results are kept where a person did; or that it packed nothing."""
    if not isinstance(run.error, StoppedError):
        return run.error or nothing_packed(asked.cell, [run])
    done = sum(len(delivery.picks) for delivery in run.deliveries)
    return StoppedError(f"{done} of {asked.picks} picks", asked.results)


def nothing_packed(cell: "Cell", runs: "list[Run]") -> LayflatError | None:
    """Return the error that no pick of these runs succeeded, with the likely cause; None where one did."""
    from layflat.cell.work.results import Summary  # noqa: PLC0415

    found = Summary(delivery for run in runs for delivery in run.deliveries)
    if found.correct:
        return None
    what = f"none of {counted(found.picks, 'pick')} succeeded in cell {cell.name!r}"
    law = cell.machine.control_law
    if cell.conveyor is None or law.plans:
        return LayflatError(what)
    right = 'give the machine [controller] kind = "tracking"'
    return LayflatError(f"{what}; control law {law.name!r} does not follow a belt: {right}")


def report(
    cell: "Cell", runs: "list[Run]", results: Path, written: list[Path], *, partial: bool = False
) -> tuple[Path, ...]:
    """Write the results, print what came of them and what was written, and which runs ended early; return all files."""
    from layflat.cell.work.results import as_dict, save  # noqa: PLC0415
    from layflat.cell.work.tables import summary  # noqa: PLC0415

    errors = {run.seed: run.error for run in runs if run.error is not None}
    path = save(as_dict(cell, runs, partial=partial or bool(errors)), results)
    deliveries = [delivery for run in runs for delivery in run.deliveries]
    if len(runs) == 1:
        _print_picks(deliveries)
    else:
        _print_runs(runs)
    for line in summary(cell, deliveries):
        typer.echo(line)
    for one in (path, *written):
        typer.echo(f"wrote {one}")
    if partial or errors:
        typer.echo(f"layflat: {path} is marked as partial", err=True)
    if len(runs) > 1:
        for seed, error in errors.items():
            typer.echo(f"layflat: seed {seed} ended early: {error}", err=True)
    return (path, *written)


def end(error: LayflatError | None) -> None:
    """Leave with an error, if there is one: a user's mistake, a Ctrl-C, or with a status of its own a rig's stop."""
    if isinstance(error, InputError | StoppedError):
        raise error
    if error is not None:
        typer.echo(f"layflat: {error}", err=True)
        raise typer.Exit(FAULT)


def _print_picks(deliveries: "list[Delivery]") -> None:
    """Print a row a pick, what went wrong, and why others were not picked."""
    from layflat.cell.work.tables import COLUMNS, not_picked, row, trouble  # noqa: PLC0415

    rows, troubles = [], []
    for number, delivery in enumerate(deliveries, start=1):
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            name = f"{number}.{pick.number}"
            rows.append(list(row(name, pick, verdict)))
            troubles.append(trouble(name, pick))
    if rows:
        print_table(list(COLUMNS), rows)
    reasons = (one.reason for delivery in deliveries for one in delivery.not_picked)
    for line in (*filter(None, troubles), *not_picked(reasons)):
        typer.echo(line)


def _print_runs(runs: "list[Run]") -> None:
    """Print a row a seed."""
    from layflat.cell.work.results import Summary  # noqa: PLC0415
    from layflat.cell.work.tables import known  # noqa: PLC0415

    rows = []
    for run in runs:
        found = Summary(run.deliveries)
        work = [f"{found.correct} of {found.picks}", known(found.picks_a_minute, 1), known(found.release_error_mm, 1)]
        strain = [known(found.peak_acceleration, 0), f"{found.collisions}", known(found.air, 1)]
        rows.append([f"{run.seed}", *work, *strain, known(found.vision_error_mm, 2)])
    errors = ["error 95 % (mm)", "peak (m/s2)", "collisions", "air (Nl)", "vision 95 % (mm)"]
    print_table(["seed", "correct", "a minute", *errors], rows)
