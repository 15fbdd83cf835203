"""The command that packs produce: pack."""

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
from layflat.cli.rig import FAULT, INTERRUPTED
from layflat.errors import InputError, LayflatError, NoDrawingError, StoppedError

if TYPE_CHECKING:
    from collections.abc import Callable

    from layflat.cell.file.model import Cell
    from layflat.cell.vision import Calibration
    from layflat.cell.work.delivery import Delivery
    from layflat.cell.work.run import Run

PICKS, STUDY_PICKS = 12, 25
FILMS = ("mp4", "gif", "none")

CellName = Annotated[str, typer.Option("--cell", metavar="NAME|FILE", help="built-in cell or description file")]


@app.command()
def pack(
    cell: CellName = "packing",
    picks: Annotated[
        int | None, typer.Option(min=1, help=f"{PICKS} where not given; of a study {STUDY_PICKS} with each seed")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="of produce, light and noise; the first one of a study")] = 0,
    out: Out = Path("build/pack"),
    calibration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="of the camera; calibrated anew where not given")
    ] = None,
    film: Annotated[str, typer.Option(help="mp4, gif or none")] = "mp4",
    study: Annotated[bool, typer.Option("--study", help="repeat with many seeds, on all cores, without films")] = False,
    seeds: Annotated[int, typer.Option(min=1, help="of a study")] = 20,
) -> None:
    """Pack produce in a physical scene, of which the cell sees only what its camera does.

    Leaves results.json, a film, and a contact sheet of what was seen of each pick. Without OpenGL there are no
    pictures: the scene tells where fruit lies, and all else goes on.
    """
    from layflat.cell import load  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    if film not in FILMS:
        raise InputError(f"{film!r} is no kind of film", where="--film", right=f"give {', '.join(FILMS)}")
    described = load(cell)
    check_folder(out)
    known = _calibration(described, calibration, out)
    if study:
        runs = _study(described, known, range(seed, seed + seeds), picks or STUDY_PICKS)
    else:
        runs = [_run(described, known, seed, picks or PICKS, out, film)]
    _report(described, runs, out)


def _calibration(cell: Cell, given: Path | None, out: Path) -> Calibration | None:
    """Of the cell's camera, from a file or made anew; None where no picture can be drawn, which is told."""
    from layflat.cell import gl  # noqa: PLC0415
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
        typer.echo("layflat: goes on without pictures; the scene tells where fruit lies", err=True)
        return None
    found.save(out / "calibration.toml")
    return found


def _run(cell: Cell, calibration: Calibration | None, seed: int, picks: int, out: Path, film: str) -> Run:
    """One run, with a film and a contact sheet where pictures can be drawn."""
    from layflat.cell.work.onlookers import Several, Tally  # noqa: PLC0415
    from layflat.cell.work.run import packed  # noqa: PLC0415
    from layflat.cell.work.show import shown  # noqa: PLC0415

    with _picks_bar(f"picks in {cell.name!r}", picks) as advance:
        if calibration is None:
            return packed(cell, seed, picks, calibration, Tally(advance))
        path = None if film == "none" else out / f"film.{film}"
        with shown(path, out / "sheet.png", f"{cell.name}, seed {seed}", calibration) as show:
            return packed(cell, seed, picks, calibration, Several(Tally(advance), show))


def _study(cell: Cell, calibration: Calibration | None, seeds: range, picks: int) -> list[Run]:
    """A run with each seed; Ctrl-C ends the study, and what is done is kept."""
    from layflat.cell.work.study import repeated  # noqa: PLC0415

    runs: list[Run] = []
    with _picks_bar(f"picks with {len(seeds)} seeds", len(seeds) * picks) as advance:
        try:
            for run in repeated(cell, seeds, picks, calibration, advance):
                runs.append(run)  # noqa: PERF402  # one by one: those before a Ctrl-C are kept
        except (KeyboardInterrupt, LayflatError) as error:
            if not runs:
                raise
            typer.echo(f"layflat: the study ended early: {error or 'stopped'}", err=True)
    return sorted(runs, key=lambda run: run.seed)


def _report(cell: Cell, runs: list[Run], out: Path) -> None:
    """Write results.json, print what came of it; a run that ended early is told last."""
    from layflat.cell.work.results import as_dict, save  # noqa: PLC0415

    path = save(as_dict(cell, runs), out / "results.json")
    deliveries = [delivery for run in runs for delivery in run.deliveries]
    if len(runs) == 1:
        _print_picks(deliveries)
    else:
        _print_runs(runs)
    _print_summary(cell, deliveries)
    typer.echo(f"wrote {path}")
    errors = [run.error for run in runs if run.error is not None]
    for error in errors:
        typer.echo(f"layflat: {error}", err=True)
    if errors:
        raise typer.Exit(_status(errors[0]))


def _status(error: LayflatError) -> int:
    """A user's mistake, a Ctrl-C, or a rig that stopped."""
    if isinstance(error, InputError):
        return 2
    return INTERRUPTED if isinstance(error, StoppedError) else FAULT


@contextmanager
def _picks_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    with steps_bar(what) as advance:
        yield lambda done: advance(done, total)


def _print_picks(deliveries: list[Delivery]) -> None:
    """A row a pick, and what went wrong."""
    rows, troubles = [], []
    for number, delivery in enumerate(deliveries, start=1):
        for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True):
            fruit, spot, name = pick.choice.fruit, pick.choice.spot, f"{number}.{pick.number}"
            rows.append(
                [
                    name,
                    f"{fruit.kind}, {fruit.grade}",
                    f"{1e3 * fruit.diameter:.0f}",
                    f"{spot.pack} {spot.place.name}",
                    verdict.told(pick),
                    _known(1e3 * verdict.release_error, 1),
                    _known(verdict.peak_acceleration, 0),
                    f"{pick.end - pick.begin:.2f}",
                    f"{pick.air:.1f}",
                ]
            )
            if pick.trouble:
                troubles.append(f"pick {name}, {pick.outcome.name.lower()}, {pick.tries} tries: {pick.trouble}")
    if rows:
        print_table(["pick", "fruit", "mm", "place", "result", "off (mm)", "peak (m/s2)", "s", "air (Nl)"], rows)
    for trouble in troubles:
        typer.echo(trouble)
    left = Counter(one.reason for delivery in deliveries for one in delivery.left)
    for reason, count in left.items():
        typer.echo(f"left {count}: {reason}")


def _known(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if isfinite(value) else ""


def _print_runs(runs: list[Run]) -> None:
    """A row a seed."""
    from layflat.cell.work.results import summary  # noqa: PLC0415

    rows = []
    for run in runs:
        found = summary(run.deliveries)
        rows.append(
            [
                f"{run.seed}",
                f"{found.right} of {found.picks}",
                f"{found.picks_a_minute:.1f}",
                f"{found.release_error_mm:.1f}",
                f"{found.peak_acceleration:.0f}",
                f"{found.collisions}",
                f"{found.air:.1f}",
                f"{found.vision_error_mm:.2f}",
            ]
        )
    columns = ["seed", "right", "a minute", "off, 95 % (mm)", "peak (m/s2)", "hits", "air (Nl)", "vision, 95 % (mm)"]
    print_table(columns, rows)


def _print_summary(cell: Cell, deliveries: list[Delivery]) -> None:
    from layflat.cell.work.results import summary  # noqa: PLC0415

    found, limits = summary(deliveries), cell.limits
    if not found.picks:
        return
    lines = [
        f"{found.right} of {found.picks} picks in the right place and grade ({found.right / found.picks:.1%}), "
        f"{found.picks_a_minute:.1f} a minute, {found.air:.1f} normal litres of air each",
        f"at release off by {found.release_error_mm:.1f} mm (95 %), {found.release_error_worst_mm:.1f} mm at most; "
        f"{found.collisions} collisions; {found.overlooked} left that could have been packed",
        f"fruit: {found.peak_acceleration:.0f} m/s2 at most (limit {limits.acceleration:.0f}), "
        f"pressed by {found.press:.0f} N at most (limit {limits.press:.0f})",
        f"seen: off by {found.vision_error_mm:.2f} mm and {found.diameter_error:.1%} of the diameter (95 %), "
        f"{found.false_finds} false finds",
    ]
    for line in lines:
        typer.echo(line)
