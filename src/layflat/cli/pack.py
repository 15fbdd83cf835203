"""Commands of packing cells: cells, pack."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import Out, app, print_table
from layflat.cli.bars import steps_bar
from layflat.cli.rig import FAULT
from layflat.errors import InputError, LayflatError, NoDrawingError, StoppedError

if TYPE_CHECKING:
    from collections.abc import Callable

    from layflat.cell.file.model import Cell
    from layflat.cell.vision import Calibration
    from layflat.cell.work.records import Delivery
    from layflat.cell.work.run import Run

PICKS, STUDY_PICKS, SEEDS = 12, 25, 20
FILMS = ("mp4", "gif", "none")
MOST = 10_000

CellName = Annotated[str, typer.Option("--cell", metavar="NAME|FILE", help="built-in cell or description file")]
Picks = Annotated[
    int | None,
    typer.Option(min=1, max=MOST, help=f"[default: {PICKS}; with --study {STUDY_PICKS} for each seed]"),
]
Seed = Annotated[
    int, typer.Option(min=0, max=2**63 - 1, help="of produce, light and noise; with --study the first of the seeds")
]
CalibrationFile = Annotated[
    Path | None, typer.Option("--calibration", metavar="FILE", help="of the camera [default: calibrate it first]")
]


@app.command()
def cells(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="print its file, to start from")] = None,
) -> None:
    """List the built-in packing cells, or print one."""
    from layflat.cell.file import load, names, text  # noqa: PLC0415

    if name is not None:
        typer.echo(text(name), nl=False)
        return
    described = [load(one) for one in names()]
    rows = [[cell.name, cell.machine.name, ", ".join(cell.container), cell.title] for cell in described]
    print_table(["cell", "machine", "containers", "title"], rows)


@app.command()
def pack(
    cell: CellName = "packing",
    picks: Picks = None,
    seed: Seed = 0,
    out: Out = Path("build/pack"),
    calibration: CalibrationFile = None,
    film: Annotated[str | None, typer.Option(help="mp4, gif or none [default: mp4]")] = None,
    study: Annotated[bool, typer.Option("--study", help="repeat with many seeds, on all cores, without films")] = False,
    seeds: Annotated[
        int | None, typer.Option(min=1, max=MOST, help=f"number of seeds with --study [default: {SEEDS}]")
    ] = None,
) -> None:
    """Pack produce in a physical scene; needs the extra `cell`.

    The cell sees only its camera's images.

    Writes results.json, calibration.toml, a film, and a contact sheet with an image of each pick. Without OpenGL there
    are no images: the scene's truth stands in for the camera.
    """
    from layflat.cell import load  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    _check_options(film, seeds, study=study)
    described = load(cell)
    check_folder(out)
    known = _calibration(described, calibration, out)
    if study:
        _study(described, known, range(seed, seed + (seeds or SEEDS)), picks or STUDY_PICKS, out)
    else:
        run, written = _run(described, known, seed, picks or PICKS, out, film or "mp4")
        _report(described, [run], out, written)
        done = sum(len(delivery.picks) for delivery in run.deliveries)
        stopped = StoppedError(f"{done} of {picks or PICKS} picks", out / "results.json")
        _end(stopped if isinstance(run.error, StoppedError) else run.error)


def _check_options(film: str | None, seeds: int | None, *, study: bool) -> None:
    if film is not None and film not in FILMS:
        raise InputError(f"unknown kind of film {film!r}", where="--film", right=f"give {', '.join(FILMS)}")
    if study and film not in {None, "none"}:
        raise InputError("cannot be combined with --study", where="--film", right="leave one of them out")
    if not study and seeds is not None:
        raise InputError("is the number of a study's seeds", where="--seeds", right="add --study, or give --seed")


def _calibration(cell: Cell, given: Path | None, out: Path) -> Calibration | None:
    """Return that of the cell's camera, from a file or made anew; say so and return None without OpenGL."""
    from layflat.cell.scene import gl  # noqa: PLC0415
    from layflat.cell.vision import load_calibration  # noqa: PLC0415
    from layflat.cell.work.run import calibrated  # noqa: PLC0415

    try:
        if given is not None:
            gl.check()
            return load_calibration(given)
        with steps_bar("calibrating the camera, per cent") as advance:
            found = calibrated(cell, lambda share: advance(round(100 * share), 100))
    except NoDrawingError as error:
        typer.echo(f"layflat: {error}", err=True)
        typer.echo("layflat: continuing without images; the scene's truth stands in for the camera", err=True)
        return None
    typer.echo(f"wrote {found.save(out / 'calibration.toml')}")
    return found


def _run(
    cell: Cell, calibration: Calibration | None, seed: int, picks: int, out: Path, film: str
) -> tuple[Run, list[Path]]:
    """Return one run, and the film and contact sheet that it wrote where images can be rendered."""
    from layflat.cell.work.film_and_sheet import film_and_sheet  # noqa: PLC0415
    from layflat.cell.work.observer import Observers, PickCounter  # noqa: PLC0415
    from layflat.cell.work.run import packed  # noqa: PLC0415

    with _picks_bar(f"picks in {cell.name!r}", picks) as advance:
        if calibration is None:
            return packed(cell, seed, picks, calibration, PickCounter(advance)), []
        path, sheet = None if film == "none" else out / f"film.{film}", out / "sheet.png"
        with film_and_sheet(path, sheet, f"{cell.name}, seed {seed}", calibration) as observer:
            run = packed(cell, seed, picks, calibration, Observers(PickCounter(advance), observer))
        return run, [sheet] if path is None else [path, sheet]


def _study(cell: Cell, calibration: Calibration | None, seeds: range, picks: int, out: Path) -> None:
    """Report a run with each seed; what was done before an error or Ctrl-C is kept and marked as partial."""
    from layflat.cell.work.study import repeated  # noqa: PLC0415

    runs: list[Run] = []
    error: LayflatError | None = None
    with _picks_bar(f"picks with {len(seeds)} seeds", len(seeds) * picks) as advance:
        try:
            for run in repeated(cell, seeds, picks, calibration, advance):
                runs.append(run)  # noqa: PERF402  # one by one: those before a Ctrl-C are kept
        except KeyboardInterrupt:
            error = StoppedError(f"{len(runs)} of {len(seeds)} seeds", out / "results.json" if runs else "")
        except LayflatError as raised:
            error = raised
    runs.sort(key=lambda run: run.seed)
    if runs:
        _report(cell, runs, out, [], partial=error is not None)
    _end(error or next((run.error for run in runs if run.error is not None), None))


def _report(cell: Cell, runs: list[Run], out: Path, written: list[Path], *, partial: bool = False) -> None:
    """Write results.json, print what came of it and what was written, and which runs ended early."""
    from layflat.cell.work.results import as_dict, save  # noqa: PLC0415

    errors = {run.seed: run.error for run in runs if run.error is not None}
    path = save(as_dict(cell, runs, partial=partial or bool(errors)), out / "results.json")
    deliveries = [delivery for run in runs for delivery in run.deliveries]
    if len(runs) == 1:
        _print_picks(deliveries)
    else:
        _print_runs(runs)
    _print_summary(cell, deliveries)
    for one in (path, *written):
        typer.echo(f"wrote {one}")
    if partial or errors:
        typer.echo(f"layflat: {path} is marked as partial", err=True)
    if len(runs) > 1:
        for seed, error in errors.items():
            typer.echo(f"layflat: seed {seed} ended early: {error}", err=True)


def _end(error: LayflatError | None) -> None:
    """Leave with an error, if there is one: a user's mistake, a Ctrl-C, or with a status of its own a rig's stop.

    Raises:
        InputError, StoppedError: as given.
    """
    if isinstance(error, InputError | StoppedError):
        raise error
    if error is not None:
        typer.echo(f"layflat: {error}", err=True)
        raise typer.Exit(FAULT)


@contextmanager
def _picks_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    with steps_bar(what) as advance:
        yield lambda done: advance(done, total)


def _print_picks(deliveries: list[Delivery]) -> None:
    """Print a row a pick, and what went wrong."""
    from layflat.cell.work.results import counted  # noqa: PLC0415

    rows, troubles = [], []
    for number, delivery in enumerate(deliveries, start=1):
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            fruit, place, name = pick.choice.fruit, pick.choice.place, f"{number}.{pick.number}"
            rows.append(
                [
                    name,
                    f"{fruit.kind}, {fruit.grade}",
                    f"{1e3 * fruit.diameter:.0f}",
                    f"{place.container} {place.name}",
                    verdict.word(pick),
                    _known(1e3 * verdict.release_error, 1),
                    _known(verdict.peak_acceleration, 0),
                    f"{pick.end - pick.begin:.2f}",
                    f"{pick.air:.1f}",
                ]
            )
            if pick.trouble:
                tries = counted(pick.tries, "try", "tries")
                troubles.append(f"pick {name}, {pick.outcome.name.lower()}, {tries}: {pick.trouble}")
    if rows:
        print_table(["pick", "fruit", "mm", "place", "result", "error (mm)", "peak (m/s2)", "s", "air (Nl)"], rows)
    for trouble in troubles:
        typer.echo(trouble)
    reasons = Counter(one.reason for delivery in deliveries for one in delivery.not_picked)
    for reason, count in reasons.items():
        typer.echo(f"{count} not picked: {reason}")


def _known(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if isfinite(value) else ""


def _print_runs(runs: list[Run]) -> None:
    """Print a row a seed."""
    from layflat.cell.work.results import summary  # noqa: PLC0415

    rows = []
    for run in runs:
        found = summary(run.deliveries)
        rows.append(
            [
                f"{run.seed}",
                f"{found.correct} of {found.picks}",
                _known(found.picks_a_minute, 1),
                _known(found.release_error_mm, 1),
                _known(found.peak_acceleration, 0),
                f"{found.collisions}",
                _known(found.air, 1),
                _known(found.vision_error_mm, 2),
            ]
        )
    errors = ["error 95 % (mm)", "peak (m/s2)", "collisions", "air (Nl)", "vision 95 % (mm)"]
    print_table(["seed", "correct", "a minute", *errors], rows)


def _print_summary(cell: Cell, deliveries: list[Delivery]) -> None:
    from layflat.cell.work.results import counted, summary  # noqa: PLC0415

    found, limits = summary(deliveries), cell.limits
    if not found.picks:
        return
    lines = [
        f"{found.correct} of {counted(found.picks, 'pick')} correct: in the chosen place, of its kind and grade "
        f"({found.correct / found.picks:.1%})",
        f"{found.picks_a_minute:.1f} picks a minute, {found.air:.1f} normal litres of air each",
    ]
    if isfinite(found.release_error_mm):
        lines.append(
            f"placement error: {found.release_error_mm:.1f} mm (95 %), {found.release_error_worst_mm:.1f} mm at most"
        )
    lines.append(f"{counted(found.collisions, 'collision')}; {found.overlooked} overlooked that could have been packed")
    if isfinite(found.peak_acceleration):
        lines.append(
            f"fruit: {found.peak_acceleration:.0f} m/s2 at most (limit {limits.acceleration:.0f}), "
            f"pressed by {found.press:.0f} N at most (limit {limits.press:.0f})"
        )
    if isfinite(found.vision_error_mm):
        lines.append(
            f"vision: position off by {found.vision_error_mm:.2f} mm, diameter by {found.diameter_error:.1%} (95 %); "
            + counted(found.false_detections, "false detection")
        )
    for line in lines:
        typer.echo(line)
