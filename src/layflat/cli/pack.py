"""Commands of packing cells: cells, pack."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import app, expanded, print_table
from layflat.cli.bars import steps_bar
from layflat.cli.pack_run import (
    CALIBRATION,
    RESULTS,
    SHEET,
    Asked,
    calibration_of,
    end,
    error_of,
    nothing_packed,
    one_run,
    report,
)
from layflat.cli.pages import PageOptions
from layflat.errors import InputError, LayflatError, StoppedError

if TYPE_CHECKING:
    from layflat.cell.file.model import Cell
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
Out = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="DIR", help="[default: build/pack, with --study build/pack-study]")
]
Study = Annotated[bool, typer.Option("--study", help="repeat with many seeds, on all cores, without films")]
OVER_HELP = "cloud: with --study, each seed packs with another machine that the paper allows"
Over = Annotated[str, typer.Option(metavar="cloud", help=OVER_HELP)]
Watch = Annotated[bool, typer.Option("--watch", help="show the run on a page in the browser; needs the extra `panel`")]
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
@expanded
def pack(
    page: PageOptions,
    cell: CellName = "packing",
    picks: Picks = None,
    seed: Seed = 0,
    out: Out = None,
    calibration: CalibrationFile = None,
    film: FilmKind = None,
    watch: Watch = False,
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
    from layflat.machine.exchanged import members  # noqa: PLC0415

    _check(film, study, seeds, over)
    _check_page(watch, study, page)
    described = load(cell)
    place = out or Path("build/pack-study" if study else "build/pack")
    pictures = [] if study else [f"film.{film or 'mp4'}", SHEET]
    check_folder(place, RESULTS, *([] if calibration else [CALIBRATION]), *pictures, costly=True)
    if study:
        machines = members(described.machine.origin) if over else []
        packed = range(seed, seed + (seeds or SEEDS))
        _study(described, calibration, packed, picks or STUDY_PICKS, place, machines)
        return
    asked = Asked(described, seed, picks or PICKS, place, film or "mp4")
    if watch:
        from layflat.cli.pack_watch import watched  # noqa: PLC0415

        watched(asked, calibration, page)
        return
    run, written = one_run(asked, calibration_of(described, calibration, place))
    report(described, [run], asked.results, written)
    end(error_of(asked, run))


def _check(film: str | None, study: bool, seeds: int | None, over: str) -> None:
    """Raise InputError for options that don't fit each other."""
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


def _check_page(watch: bool, study: bool, page: PageOptions) -> None:
    if watch and study:
        raise InputError("cannot be combined with --study", where="--watch", right="leave one of them out")
    if page.given and not watch:
        raise InputError("is for the page", where=page.given, right="add --watch, or leave it out")


def _study(cell: Cell, calibration: Path | None, seeds: range, picks: int, out: Path, machines: list[str]) -> None:
    """Report a run with each seed; what was done before an error or Ctrl-C is kept and marked as partial."""
    from layflat.cell.work.run import repeated  # noqa: PLC0415

    known, results = calibration_of(cell, calibration, out), out / RESULTS
    runs: list[Run] = []
    error: LayflatError | None = None
    with steps_bar(f"picks with {len(seeds)} seeds", len(seeds) * picks) as advance:
        try:
            for run in repeated(cell, seeds, picks, known, advance, machines=machines):
                runs.append(run)  # noqa: PERF402  # one by one: those before a Ctrl-C are kept
        except KeyboardInterrupt:
            error = StoppedError(f"{len(runs)} of {len(seeds)} seeds", results if runs else "")
        except LayflatError as raised:
            error = raised
    runs.sort(key=lambda run: run.seed)
    if runs:
        report(cell, runs, results, [], partial=error is not None)
    end(error or next((run.error for run in runs if run.error is not None), nothing_packed(cell, runs)))
