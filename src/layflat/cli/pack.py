"""Commands that list and show packing cells, and pack in one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import steps_bar
from layflat.cli.common import expanded, naming_options, print_table
from layflat.cli.completers import complete_choice, complete_name
from layflat.cli.groups import cells
from layflat.cli.pack_run import (
    CALIBRATION_FILE,
    RESULTS_FILE,
    SHEET_FILE,
    PackRequest,
    calibration_of,
    error_of,
    nothing_packed,
    raise_error,
    report_runs,
    run_once,
    run_with_page,
)
from layflat.cli.pages import PageOptions
from layflat.errors import InputError, LayflatError, StoppedError

if TYPE_CHECKING:
    from layflat.cell.file.model import Cell
    from layflat.cell.work.run import PackingRun

DEFAULT_PICKS, DEFAULT_STUDY_PICKS, DEFAULT_SEEDS = 12, 25, 20
FILM_KINDS = ("mp4", "gif", "none")
MAX_COUNT = 10_000  # of picks, and of seeds

CellName = Annotated[
    str,
    typer.Option(
        "--cell", metavar="NAME|FILE", help="built-in cell or description file", autocompletion=complete_name("cell")
    ),
]
PICKS_HELP = f"[default: {DEFAULT_PICKS}; with --study {DEFAULT_STUDY_PICKS} for each seed]"
Picks = Annotated[int | None, typer.Option(min=1, max=MAX_COUNT, help=PICKS_HELP)]
SEED_HELP = "of produce, light and noise; with --study the first of the seeds"
Seed = Annotated[int, typer.Option(min=0, max=2**63 - 1, help=SEED_HELP)]
CAMERA_HELP = "of the camera [default: calibrate it first]"
CalibrationFile = Annotated[Path | None, typer.Option("--calibration", metavar="FILE", help=CAMERA_HELP)]
FilmKind = Annotated[
    str | None, typer.Option(help="mp4, gif or none [default: mp4]", autocompletion=complete_choice(*FILM_KINDS))
]
Out = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="DIR", help="[default: build/pack, with --study build/pack-study]")
]
Watch = Annotated[bool, typer.Option("--watch", help="show the run on a page in the browser; needs the extra `panel`")]


@dataclass(frozen=True)
class StudyOptions:
    """Options about a study over many seeds (see `expanded`)."""

    study: Annotated[bool, typer.Option("--study", help="repeat with many seeds, on all cores, without films")] = False
    seeds: Annotated[
        int | None, typer.Option(min=1, max=MAX_COUNT, help=f"number of seeds with --study [default: {DEFAULT_SEEDS}]")
    ] = None
    over: Annotated[
        str,
        typer.Option(
            metavar="cloud", help="cloud: with --study, each seed packs with another machine that the paper allows"
        ),
    ] = ""


@dataclass(frozen=True)
class DatasetOptions:
    """Options about a LeRobot data set of a run (see `expanded`)."""

    lerobot: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="write each pick as an episode of a LeRobot data set; needs the extra `logs`"),
    ] = None
    lerobot_fps: Annotated[int, typer.Option(help="its frames a second")] = 10

    def check(self, cell: Cell, study: bool, out: Path) -> None:
        """Check these options before a run.

        Args:
            cell: cell that packs.
            study: whether a study of many seeds is requested.
            out: folder of the other results.

        Raises:
            InputError: a rate without a data set, or one at which frames fall between control cycles; a data set of a
                study, or among the other results.
            MissingExtraError: pyarrow is not installed.
            OutputError: the folder is not empty.
        """
        if self.lerobot is None:
            if self.lerobot_fps != DatasetOptions.lerobot_fps:
                raise InputError("is for a data set", where="--lerobot-fps", right="add --lerobot, or leave it out")
            return
        if study:
            raise InputError("cannot be combined with --study", where="--lerobot", right="leave one of them out")
        if self.lerobot.resolve() == out.resolve():
            raise InputError("is the folder of the other results", where="--lerobot", right="give one of its own")
        from layflat.cell.work.episodes import cycles_per_frame  # noqa: PLC0415
        from layflat.lerobot.writer import check_target  # noqa: PLC0415

        check_target(self.lerobot)
        with naming_options({"fps": "--lerobot-fps"}):
            cycles_per_frame(cell.machine.cycle, self.lerobot_fps)


@cells.register("list", "")
def list_cells() -> None:
    """List the built-in packing cells."""
    from layflat.cell.file.loader import load, names  # noqa: PLC0415

    described = [load(one) for one in names()]
    rows = [[cell.name, cell.machine.name, ", ".join(cell.container), cell.title] for cell in described]
    print_table(["cell", "machine", "containers", "title"], rows)


@cells.register("show", "packing > cell.toml")
def show_cell(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="built-in cell", autocompletion=complete_name("cell", files=False))
    ],
) -> None:
    """Print the file of a packing cell, to start from."""
    from layflat.cell.file.loader import text  # noqa: PLC0415

    typer.echo(text(name), nl=False)


@cells.register("pack", "", "--cell belt --watch", "--study --seeds 50 --film none")
@expanded
def pack_produce(
    page: PageOptions,
    cell: CellName = "packing",
    picks: Picks = None,
    seed: Seed = 0,
    out: Out = None,
    calibration: CalibrationFile = None,
    film: FilmKind = None,
    watch: Watch = False,
    *,
    study: StudyOptions,
    dataset: DatasetOptions,
) -> None:
    """Pack produce in a physical scene.

    Needs the extra `cell`. The cell sees only its camera's images.

    Writes results.json, calibration.toml, a film, and a contact sheet with an image of each pick. Without OpenGL there
    are no images: the scene's truth stands in for the camera.
    """
    from layflat.cell import load  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine.exchanged import member_names  # noqa: PLC0415

    _check_options(film, study)
    _check_page(watch, study.study, page)
    described = load(cell)
    place = out or Path("build/pack-study" if study.study else "build/pack")
    dataset.check(described, study.study, place)
    pictures = [] if study.study else [f"film.{film or 'mp4'}", SHEET_FILE]
    check_folder(place, RESULTS_FILE, *([] if calibration else [CALIBRATION_FILE]), *pictures, costly=True)
    if study.study:
        machines = member_names(described.machine.origin) if study.over else []
        packed = range(seed, seed + (study.seeds or DEFAULT_SEEDS))
        _run_study(described, calibration, packed, picks or DEFAULT_STUDY_PICKS, place, machines)
        return
    request = PackRequest(
        described, seed, picks or DEFAULT_PICKS, place, film or "mp4", dataset.lerobot, dataset.lerobot_fps
    )
    if watch:
        run_with_page(request, calibration, page)
        return
    run, written = run_once(request, calibration_of(described, calibration, place))
    report_runs(described, [run], request.results, written)
    raise_error(error_of(request, run))


def _check_options(film: str | None, study: StudyOptions) -> None:
    """Raise InputError for options that can't be combined."""
    if film is not None and film not in FILM_KINDS:
        raise InputError(f"unknown kind of film {film!r}", where="--film", right=f"give {', '.join(FILM_KINDS)}")
    if study.study and film not in {None, "none"}:
        raise InputError("cannot be combined with --study", where="--film", right="leave one of them out")
    if not study.study and study.seeds is not None:
        raise InputError("is the number of a study's seeds", where="--seeds", right="add --study, or give --seed")
    if study.over not in {"", "cloud"}:
        raise InputError(f"{study.over!r} is nothing to pack over", where="--over", right="give cloud, or leave it out")
    if study.over and not study.study:
        raise InputError("is for a study", where="--over", right="add --study, or leave it out")


def _check_page(watch: bool, study: bool, page: PageOptions) -> None:
    """Raise InputError for a page of a study, and for options of the page without --watch."""
    if watch and study:
        raise InputError("cannot be combined with --study", where="--watch", right="leave one of them out")
    if page.changed_option and not watch:
        raise InputError("is for the page", where=page.changed_option, right="add --watch, or leave it out")


def _run_study(cell: Cell, calibration: Path | None, seeds: range, picks: int, out: Path, machines: list[str]) -> None:
    """Run and report all seeds; runs before an error or Ctrl-C are kept and marked as partial.

    Then raise that error, the first of a run, or that no pick succeeded, as `raise_error`.
    """
    from layflat.cell.work.run import run_seeds  # noqa: PLC0415

    camera_calibration, results = calibration_of(cell, calibration, out), out / RESULTS_FILE
    runs: list[PackingRun] = []
    error: LayflatError | None = None
    with steps_bar(f"picks with {len(seeds)} seeds", len(seeds) * picks) as advance:
        try:
            for run in run_seeds(cell, seeds, picks, camera_calibration, advance, machines=machines):
                runs.append(run)  # noqa: PERF402  # one by one: those before a Ctrl-C are kept
        except KeyboardInterrupt:
            error = StoppedError(f"{len(runs)} of {len(seeds)} seeds", results if runs else "")
        except LayflatError as raised:
            error = raised
    runs.sort(key=lambda run: run.seed)
    if runs:
        report_runs(cell, runs, results, [], partial=error is not None)
    raise_error(error or next((run.error for run in runs if run.error is not None), nothing_packed(cell, runs)))
