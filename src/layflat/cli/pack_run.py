"""Helpers of the commands that pack: calibration, run, and report of its results.

With `layflat cell pack --watch` a page in the browser shows the run.
"""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from layflat import extras
from layflat.cli.bars import steps_bar
from layflat.cli.common import count_noun, naming_options, print_table
from layflat.cli.pages import OPTIONS, PageOptions
from layflat.cli.rig import FAULT_EXIT
from layflat.errors import InputError, LayflatError, NoDrawingError, StoppedError

if TYPE_CHECKING:
    from layflat.cell.file.model import Cell
    from layflat.cell.vision import Calibration
    from layflat.cell.work.observer import Delivery, Observer
    from layflat.cell.work.run import PackingRun
    from layflat.pages.cell.link import PageLink


RESULTS_FILE, CALIBRATION_FILE, SHEET_FILE = "results.json", "calibration.toml", "sheet.png"


@dataclass(frozen=True)
class PackRequest:
    """Request for a run of a cell."""

    cell: "Cell"
    seed: int
    picks: int
    out: Path
    film: str  # its kind, or "none"
    dataset: Path | None = None  # folder of a LeRobot data set, if any
    dataset_fps: int = 0  # its frames a second

    @property
    def results(self) -> Path:
        """The file of the results."""
        return self.out / RESULTS_FILE


def calibration_of(
    cell: "Cell", file: Path | None, out: Path, progress: Callable[[float], object] = lambda _: None
) -> "Calibration | None":
    """Return the calibration of the cell's camera; without OpenGL print a notice and return None.

    Args:
        cell: cell with the camera.
        file: file of a calibration; None calibrates the camera.
        out: folder in which a new calibration is written.
        progress: called with the fraction of a new calibration done, 0..1.

    Raises:
        CameraError: the file is missing or holds no calibration, whether or not there is OpenGL.
    """
    from layflat.bridge.view.picture import gl_context  # noqa: PLC0415
    from layflat.cell.vision import load_calibration  # noqa: PLC0415
    from layflat.cell.work.run import calibrate_cell  # noqa: PLC0415

    try:
        if file is not None:
            calibration = load_calibration(file)
            gl_context(16, 16).free()
            return calibration
        with steps_bar("calibrating the camera, per cent", 100) as advance:

            def show(fraction: float) -> None:
                advance(round(100 * fraction))
                progress(fraction)

            calibration = calibrate_cell(cell, show)
    except NoDrawingError as error:
        typer.echo(f"layflat: {error}", err=True)
        typer.echo("layflat: continuing without images; the scene's truth stands in for the camera", err=True)
        return None
    typer.echo(f"wrote {calibration.save(out / CALIBRATION_FILE)}")
    return calibration


def run_once(
    request: PackRequest, calibration: "Calibration | None", *observers: "Observer"
) -> "tuple[PackingRun, list[Path]]":
    """Pack once; return the run, and the paths of its film and sheet, where images can be rendered, and data set."""
    from layflat.cell.work.episodes import record_episodes  # noqa: PLC0415
    from layflat.cell.work.film_and_sheet import record_film_and_sheet  # noqa: PLC0415
    from layflat.cell.work.observer import Observers, PickCounter  # noqa: PLC0415
    from layflat.cell.work.run import run_packing  # noqa: PLC0415

    cell, seed, picks, dataset = request.cell, request.seed, request.picks, request.dataset
    sheet = request.out / SHEET_FILE
    film = None if request.film == "none" else request.out / f"film.{request.film}"
    with steps_bar(f"picks in {cell.name!r}", picks) as advance, ExitStack() as stack:
        watching = [PickCounter(advance), *observers]
        if dataset is not None:
            fps, pictures = request.dataset_fps, calibration is not None
            watching.append(stack.enter_context(record_episodes(dataset, cell, fps, pictures=pictures)))
        if calibration is not None:
            title = f"{cell.name}, seed {seed}"
            watching.append(stack.enter_context(record_film_and_sheet(film, sheet, title, calibration)))
        run = run_packing(cell, seed, picks, calibration, Observers(*watching))
    written = [path for path in (film, sheet) if path is not None] if calibration is not None else []
    return run, written + ([dataset] if dataset is not None and dataset.exists() else [])


def error_of(request: PackRequest, run: "PackingRun") -> LayflatError | None:
    """Return the error that ended a run early, or that no pick succeeded; after Ctrl-C with the path of the results."""
    if not isinstance(run.error, StoppedError):
        return run.error or nothing_packed(request.cell, [run])
    done = sum(len(delivery.picks) for delivery in run.deliveries)
    return StoppedError(f"{done} of {request.picks} picks", request.results)


def nothing_packed(cell: "Cell", runs: "list[PackingRun]") -> LayflatError | None:
    """Return the error that no pick of these runs succeeded, with the likely cause; None where one did."""
    from layflat.cell.work.results import PackingSummary  # noqa: PLC0415

    summary = PackingSummary(delivery for run in runs for delivery in run.deliveries)
    if summary.correct:
        return None
    what = f"none of {count_noun(summary.picks, 'pick')} succeeded in cell {cell.name!r}"
    law = cell.machine.control_law
    if cell.conveyor is None or law.plans:
        return LayflatError(what)
    right = 'give the machine [controller] kind = "tracking"'
    return LayflatError(f"{what}; control law {law.name!r} does not follow a belt: {right}")


def report_runs(
    cell: "Cell", runs: "list[PackingRun]", results: Path, written: list[Path], *, partial: bool = False
) -> tuple[Path, ...]:
    """Write the results and print them, with the files written and the runs that ended early; return all files.

    Args:
        cell: cell of the runs.
        runs: one run, or one for each seed.
        results: path of the results' file.
        written: files that were written before.
        partial: whether runs are missing.
    """
    from layflat.cell.work.results import record_runs, save_results, summary_lines  # noqa: PLC0415

    errors = {run.seed: run.error for run in runs if run.error is not None}
    path = save_results(record_runs(cell, runs, partial=partial or bool(errors)), results)
    deliveries = [delivery for run in runs for delivery in run.deliveries]
    if len(runs) == 1:
        _print_picks(deliveries)
    else:
        _print_runs(runs)
    for line in summary_lines(cell, deliveries):
        typer.echo(line)
    for file in (path, *written):
        typer.echo(f"wrote {file}")
    if partial or errors:
        typer.echo(f"layflat: {path} is marked as partial", err=True)
    if len(runs) > 1:
        for seed, error in errors.items():
            typer.echo(f"layflat: seed {seed} ended early: {error}", err=True)
    return (path, *written)


def raise_error(error: LayflatError | None) -> None:
    """Raise an error of the user or a Ctrl-C; exit with `FAULT_EXIT` and a line on any other; return for None."""
    if isinstance(error, InputError | StoppedError):
        raise error
    if error is not None:
        typer.echo(f"layflat: {error}", err=True)
        raise typer.Exit(FAULT_EXIT)


def _print_picks(deliveries: "list[Delivery]") -> None:
    """Print a row a pick, the failures, and the reasons for which other fruit was not picked."""
    from layflat.cell.work.results import COLUMNS, count_reasons, describe_trouble, pick_row  # noqa: PLC0415

    rows, troubles = [], []
    for number, delivery in enumerate(deliveries, start=1):
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            name = f"{number}.{pick.number}"
            rows.append(list(pick_row(name, pick, verdict)))
            troubles.append(describe_trouble(name, pick))
    if rows:
        print_table(list(COLUMNS), rows)
    reasons = (one.reason for delivery in deliveries for one in delivery.not_picked)
    for line in (*filter(None, troubles), *count_reasons(reasons)):
        typer.echo(line)


def _print_runs(runs: "list[PackingRun]") -> None:
    """Print a row a seed."""
    from layflat.cell.work.results import PackingSummary, format_finite  # noqa: PLC0415

    rows = []
    for run in runs:
        summary = PackingSummary(run.deliveries)
        work = [
            f"{summary.correct} of {summary.picks}",
            format_finite(summary.picks_a_minute, 1),
            format_finite(summary.release_error_mm, 1),
        ]
        strain = [format_finite(summary.peak_acceleration, 0), f"{summary.collisions}", format_finite(summary.air, 1)]
        rows.append([f"{run.seed}", *work, *strain, format_finite(summary.vision_error_mm, 2)])
    errors = ["error 95 % (mm)", "peak (m/s2)", "collisions", "air (Nl)", "vision 95 % (mm)"]
    print_table(["seed", "correct", "a minute", *errors], rows)


def run_with_page(request: PackRequest, calibration: Path | None, page: PageOptions) -> None:
    """Pack while a page shows the run; the page stays until Ctrl-C, which before the end of the run ends both.

    Args:
        request: run that is requested.
        calibration: file of the camera's calibration; None calibrates it.
        page: options of the page.
    """
    from layflat.cell.work.results import COLUMNS  # noqa: PLC0415
    from layflat.pages.cell.link import PageLink  # noqa: PLC0415
    from layflat.pages.cell.snapshot import RunStage, RunSubject  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    require_posix("--watch")
    extras.require("panel", "nicegui", where="--watch")
    place = page.endpoint()
    about = RunSubject(request.cell.name, request.cell.machine.name, request.seed, request.picks, COLUMNS)
    with naming_options(OPTIONS):
        link = PageLink(about, place)
    with link:
        page.announce(request.cell.name, link.link)
        error: LayflatError | None
        try:
            error = _run_and_report(request, calibration, link)
        except KeyboardInterrupt:
            if not link.requests.stop:
                raise
            error = StoppedError(f"0 of {request.picks} picks")
        except LayflatError as raised:
            error = raised
        link.show(stage=RunStage.ENDED, error=str(error or ""))
        if link.requests.stop or not isinstance(error, StoppedError):
            _wait(link, error)
    raise_error(error)


def _run_and_report(request: PackRequest, calibration: Path | None, link: "PageLink") -> LayflatError | None:
    """Pack once, show the run on its page and write the results; return its error as `error_of`."""
    from layflat.cell.work.results import summary_lines  # noqa: PLC0415
    from layflat.pages.cell.watcher import Watcher  # noqa: PLC0415

    camera_calibration = calibration_of(
        request.cell, calibration, request.out, lambda share: link.show(calibrated=share)
    )
    link.show(images=camera_calibration is not None)
    run, written = run_once(request, camera_calibration, Watcher(link))
    files = report_runs(request.cell, [run], request.results, written)
    link.show(summary=tuple(summary_lines(request.cell, run.deliveries)), written=tuple(str(path) for path in files))
    return error_of(request, run)


def _wait(link: "PageLink", error: LayflatError | None) -> None:
    """Print how the run ended, and serve the page until Ctrl-C or the end of its process."""
    how = f" early: {error}" if error is not None else ""
    typer.echo(f"the run has ended{how}; the page stays until Ctrl-C")
    try:
        link.wait()
    except KeyboardInterrupt:
        return
    typer.echo("layflat: the page's process is gone", err=True)
