"""Commands of packing cells: cells, pack."""

from __future__ import annotations

from collections import Counter
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import Out, app, print_table
from layflat.cli.bars import steps_bar
from layflat.cli.rig import FAULT
from layflat.errors import InputError, LayflatError, NoDrawingError, StoppedError

if TYPE_CHECKING:
    from layflat.cell.file.model import Cell
    from layflat.cell.vision import Calibration
    from layflat.cell.work.records import Delivery
    from layflat.cell.work.run import Run

PICKS, STUDY_PICKS, SEEDS = 12, 25, 20
FILMS = ("mp4", "gif", "none")
MOST = 10_000

CellName = Annotated[str, typer.Option("--cell", metavar="NAME|FILE", help="built-in cell or description file")]
PICKS_HELP = f"[default: {PICKS}; with --study {STUDY_PICKS} for each seed]"
Picks = Annotated[int | None, typer.Option(min=1, max=MOST, help=PICKS_HELP)]
SEED_HELP = "of produce, light and noise; with --study the first of the seeds"
Seed = Annotated[int, typer.Option(min=0, max=2**63 - 1, help=SEED_HELP)]
CAMERA_HELP = "of the camera [default: calibrate it first]"
CalibrationFile = Annotated[Path | None, typer.Option("--calibration", metavar="FILE", help=CAMERA_HELP)]
FilmKind = Annotated[str | None, typer.Option(help="mp4, gif or none [default: mp4]")]
Study = Annotated[bool, typer.Option("--study", help="repeat with many seeds, on all cores, without films")]
OVER_HELP = "cloud: with --study, each seed packs with another machine that the paper allows"
Over = Annotated[str, typer.Option(metavar="cloud", help=OVER_HELP)]
Seeds = Annotated[int | None, typer.Option(min=1, max=MOST, help=f"number of seeds with --study [default: {SEEDS}]")]


@app.command()
def cells(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="print its file, to start from")] = None,
) -> None:
    """List the built-in packing cells, or print one."""
    from layflat.cell.file.loader import load, names, text  # noqa: PLC0415

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
    film: FilmKind = None,
    study: Study = False,
    seeds: Seeds = None,
    over: Over = "",
) -> None:
    """Pack produce in a physical scene; needs the extra `cell`.

    The cell sees only its camera's images.

    Writes results.json, calibration.toml, a film, and a contact sheet with an image of each pick. Without OpenGL there
    are no images: the scene's truth stands in for the camera.
    """
    from layflat.cell import load  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine.members import members  # noqa: PLC0415

    if film is not None and film not in FILMS:
        raise InputError(f"unknown kind of film {film!r}", where="--film", right=f"give {', '.join(FILMS)}")
    if study and film not in {None, "none"}:
        raise InputError("cannot be combined with --study", where="--film", right="leave one of them out")
    if not study and seeds is not None:
        raise InputError("is the number of a study's seeds", where="--seeds", right="add --study, or give --seed")
    if over not in {"", "cloud"}:
        raise InputError(f"{over!r} is nothing to pack over", where="--over", right="give cloud, or leave it out")
    if over and not study:
        raise InputError("is for a study", where="--over", right="add --study, or leave it out")
    described = load(cell)
    machines = members(described.machine.origin) if over else []
    check_folder(out)
    known = _calibration(described, calibration, out)
    if study:
        _study(described, known, range(seed, seed + (seeds or SEEDS)), picks or STUDY_PICKS, out, machines)
    else:
        run, written = _run(described, known, seed, picks or PICKS, out, film or "mp4")
        _report(described, [run], out, written)
        done = sum(len(delivery.picks) for delivery in run.deliveries)
        stopped = StoppedError(f"{done} of {picks or PICKS} picks", out / "results.json")
        _end(stopped if isinstance(run.error, StoppedError) else run.error)


def _calibration(cell: Cell, given: Path | None, out: Path) -> Calibration | None:
    """Return that of the cell's camera, from a file or made anew; say so and return None without OpenGL."""
    from layflat.bridge.view.opengl import context  # noqa: PLC0415
    from layflat.cell.vision import load_calibration  # noqa: PLC0415
    from layflat.cell.work.run import calibrated  # noqa: PLC0415

    try:
        if given is not None:
            context(16, 16).free()
            return load_calibration(given)
        with steps_bar("calibrating the camera, per cent", 100) as advance:
            found = calibrated(cell, lambda share: advance(round(100 * share)))
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

    with steps_bar(f"picks in {cell.name!r}", picks) as advance:
        if calibration is None:
            return packed(cell, seed, picks, calibration, PickCounter(advance)), []
        path, sheet = None if film == "none" else out / f"film.{film}", out / "sheet.png"
        with film_and_sheet(path, sheet, f"{cell.name}, seed {seed}", calibration) as observer:
            run = packed(cell, seed, picks, calibration, Observers(PickCounter(advance), observer))
        return run, [sheet] if path is None else [path, sheet]


def _study(
    cell: Cell, calibration: Calibration | None, seeds: range, picks: int, out: Path, machines: list[str]
) -> None:
    """Report a run with each seed; what was done before an error or Ctrl-C is kept and marked as partial."""
    from layflat.cell.work.study import repeated  # noqa: PLC0415

    runs: list[Run] = []
    error: LayflatError | None = None
    with steps_bar(f"picks with {len(seeds)} seeds", len(seeds) * picks) as advance:
        try:
            for run in repeated(cell, seeds, picks, calibration, advance, machines=machines):
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
    """Leave with an error, if there is one: a user's mistake, a Ctrl-C, or with a status of its own a rig's stop."""
    if isinstance(error, InputError | StoppedError):
        raise error
    if error is not None:
        typer.echo(f"layflat: {error}", err=True)
        raise typer.Exit(FAULT)


def _print_picks(deliveries: list[Delivery]) -> None:
    """Print a row a pick, what went wrong, and why others were not picked."""
    from layflat.cell.work.results import counted  # noqa: PLC0415

    rows, troubles = [], []
    for number, delivery in enumerate(deliveries, start=1):
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            fruit, place, name = pick.choice.fruit, pick.choice.place, f"{number}.{pick.number}"
            what = [f"{fruit.kind}, {fruit.grade}", f"{1e3 * fruit.diameter:.0f}", f"{place.container} {place.name}"]
            true = [_known(1e3 * verdict.release_error, 1), _known(verdict.peak_acceleration, 0)]
            rows.append([name, *what, verdict.word(pick), *true, f"{pick.end - pick.begin:.2f}", f"{pick.air:.1f}"])
            if pick.trouble:
                tries = counted(pick.tries, "try", "tries")
                troubles.append(f"pick {name}, {pick.outcome.name.lower()}, {tries}: {pick.trouble}")
    if rows:
        print_table(["pick", "fruit", "mm", "place", "result", "error (mm)", "peak (m/s2)", "s", "air (Nl)"], rows)
    reasons = Counter(one.reason for delivery in deliveries for one in delivery.not_picked)
    for line in (*troubles, *(f"{count} not picked: {reason}" for reason, count in reasons.items())):
        typer.echo(line)


def _print_runs(runs: list[Run]) -> None:
    """Print a row a seed."""
    from layflat.cell.work.results import Summary  # noqa: PLC0415

    rows = []
    for run in runs:
        found = Summary(run.deliveries)
        work = [f"{found.correct} of {found.picks}", _known(found.picks_a_minute, 1), _known(found.release_error_mm, 1)]
        strain = [_known(found.peak_acceleration, 0), f"{found.collisions}", _known(found.air, 1)]
        rows.append([f"{run.seed}", *work, *strain, _known(found.vision_error_mm, 2)])
    errors = ["error 95 % (mm)", "peak (m/s2)", "collisions", "air (Nl)", "vision 95 % (mm)"]
    print_table(["seed", "correct", "a minute", *errors], rows)


def _known(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if isfinite(value) else ""


def _print_summary(cell: Cell, deliveries: list[Delivery]) -> None:
    from layflat.cell.work.results import Summary, counted  # noqa: PLC0415

    found, limits = Summary(deliveries), cell.limits
    if not found.picks:
        return
    share = f"{found.correct / found.picks:.1%}"
    picks, collisions = counted(found.picks, "pick"), counted(found.collisions, "collision")
    worst, false = found.release_error_worst_mm, counted(found.false_detections, "false detection")
    typer.echo(f"{found.correct} of {picks} correct: in the chosen place, of its kind and grade ({share})")
    typer.echo(f"{found.picks_a_minute:.1f} picks a minute, {found.air:.1f} normal litres of air each")
    if isfinite(found.release_error_mm):
        typer.echo(f"placement error: {found.release_error_mm:.1f} mm (95 %), {worst:.1f} mm at most")
    typer.echo(f"{collisions}; {found.overlooked} overlooked that could have been packed")
    if isfinite(found.peak_acceleration):
        peak = f"{found.peak_acceleration:.0f} m/s2 at most (limit {limits.acceleration:.0f})"
        typer.echo(f"fruit: {peak}, pressed by {found.press:.0f} N at most (limit {limits.press:.0f})")
    if isfinite(found.vision_error_mm):
        errors = f"position off by {found.vision_error_mm:.2f} mm, diameter by {found.diameter_error:.1%} (95 %)"
        typer.echo(f"vision: {errors}; {false}")
