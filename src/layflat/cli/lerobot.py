"""Command that writes logs as a LeRobot data set: log lerobot."""

from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import busy, in_background
from layflat.cli.common import Out, count_noun, naming_options
from layflat.cli.completers import complete_choice
from layflat.cli.groups import logs
from layflat.cli.log import MappingFile, OfMachine

if TYPE_CHECKING:
    from layflat.identify.logs.table import LogTable

OPTION_NAMES = {name: f"--{name}" for name in ("task", "fps", "action", "episodes", "machine", "joints")} | {
    "cycle": "--fps",
    "joints": "--machine",
}


@logs.register(
    "lerobot",
    'run.mcap --task "move to the target" --episodes move',
    'a.nc b.nc --task "swing" --fps 50 --action voltage',
)
def write_dataset(
    log_files: Annotated[list[Path], typer.Argument(metavar="LOG...", help="CSV, Parquet, NetCDF or MCAP")],
    task: Annotated[list[str], typer.Option(help="what the machine does, in words; repeat it for one each log")],
    out: Out = Path("build/lerobot"),
    fps: Annotated[int | None, typer.Option(help="frames a second  [default: the rate of the first log]")] = None,
    action: Annotated[
        str, typer.Option(help="demand or voltage", autocompletion=complete_choice("demand", "voltage"))
    ] = "demand",
    episodes: Annotated[
        str, typer.Option(help="what makes an episode: log or move", autocompletion=complete_choice("log", "move"))
    ] = "log",
    mapping: MappingFile = None,
    machine: OfMachine = None,
) -> None:
    """Write logs and simulated runs as a LeRobot data set.

    The folder has LeRobot's layout, version 3.0: angles and pressures as `observation.state`, and `action`. Needs the
    extra `logs`.
    """
    from layflat.identify.logs import write_lerobot  # noqa: PLC0415

    with naming_options(OPTION_NAMES), ExitStack() as status:
        written = write_lerobot(
            [partial(_read, path, status) for path in log_files],
            out,
            task=task,
            fps=fps,
            action=action,  # type: ignore[arg-type]  # checked there
            episodes=episodes,  # type: ignore[arg-type]
            mapping=mapping,
            machine=machine,
        )
    frames = f"{count_noun(written.frames, 'frame')} at {written.fps} a second"
    typer.echo(f"wrote {out}: {count_noun(written.episodes, 'episode')}, {frames}")


def _read(path: Path, status: ExitStack) -> "LogTable":
    """Return the table of a log's file; show the time that reading takes, and then, in `status`, the writing."""
    from layflat.identify.logs import read_table  # noqa: PLC0415

    done = [0.0]

    def advance(fraction: float) -> None:
        """Store the fraction that is read."""
        done[0] = fraction

    status.close()
    table: LogTable = in_background(partial(read_table, path, advance), f"reading {path.name}", lambda: done[0], "")
    status.enter_context(busy(f"writing {path.name}"))
    return table
