"""Command that shows runs and logs in Foxglove, and the option by which commands show a rig there."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import bar, busy
from layflat.cli.common import naming_options
from layflat.cli.completers import complete_name
from layflat.cli.groups import app
from layflat.errors import InputError

if TYPE_CHECKING:
    import xarray

    from layflat.machine import Machine
    from layflat.rig.session import RigSnapshot

OPTIONS = {name: f"--{name}" for name in ("speed", "host", "port", "machine")}

FoxglovePort = Annotated[
    int | None,
    typer.Option(
        "--foxglove", metavar="PORT", min=0, max=65535, help="show it live in Foxglove; 0 is any port that is free"
    ),
]


@app.register("foxglove", "build/rig/run.mcap", "run.nc --speed 0.5", "run.nc --out run.mcap")
def show_in_foxglove(
    log: Annotated[
        Path, typer.Argument(metavar="RUN|LOG", help="run of `layflat simulate`, log of a rig or of a test bench")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="write an MCAP file instead, NAME.mcap")
    ] = None,
    speed: Annotated[float | None, typer.Option(help="of playing, until a viewer changes it  [default: 1]")] = None,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="of the server; 0 is any that is free  [default: 8765]")
    ] = None,
    host: Annotated[
        str | None, typer.Option(help="address by which viewers reach this computer  [default: 127.0.0.1]")
    ] = None,
    machine: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE", help="whose arm is shown, if not the log's", autocompletion=complete_name("machine")
        ),
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option(metavar="FILE", help="what a bench log's columns are (see `layflat log map`)")
    ] = None,
) -> None:
    """Play a run or log to Foxglove, or write it as a file for it.

    Shows joint states, the arm in space, pressures and all other signals, and faults. It plays once Foxglove connects,
    and obeys Foxglove's controls, until Ctrl-C. Needs the extra `foxglove`.
    """
    from layflat import extras  # noqa: PLC0415

    extras.require("foxglove", where="foxglove")
    given = {"--speed": speed, "--port": port, "--host": host}
    extra = next((option for option, value in given.items() if value is not None), None)
    if out is not None and extra is not None:
        raise InputError("is for playing, and --out writes a file", where=extra, right="give one of both")
    data = _read(log, mapping, machine)
    if out is not None:
        _write_file(data, out, machine)
        return
    from layflat.cli.rig import stopping  # noqa: PLC0415
    from layflat.foxglove.playback import Playback  # noqa: PLC0415
    from layflat.foxglove.server import DEFAULT_PORT, LOCAL_HOST  # noqa: PLC0415

    with stopping() as stopped, naming_options(OPTIONS):
        playback = Playback(
            data,
            machine=machine,
            speed=1.0 if speed is None else speed,
            host=host or LOCAL_HOST,
            port=DEFAULT_PORT if port is None else port,
        )
        with playback:
            if not playback.shows_arm:
                typer.echo(f"{log.name}: without an arm: give --machine, and a log with angles of its joints")
            _print_address(log.name, playback.address, playback.link)
            playback.serve(stopped)


@contextmanager
def showing_in_foxglove(
    machine: "Machine", port: int | None
) -> "Iterator[Callable[[Callable[[], RigSnapshot | None]], None]]":
    """Serve a rig to Foxglove within the block; yield a function that takes the source of its cycles.

    Args:
        machine: machine of the rig.
        port: port of the server; 0: any free one; None: nothing is served.

    Raises:
        InputError: the port can't be had.
        MissingExtraError: Foxglove's SDK is not installed.
    """
    if port is None:
        yield lambda _: None
        return
    from layflat import extras  # noqa: PLC0415

    extras.require("foxglove", where="--foxglove")
    from layflat.foxglove.rig import RigServer  # noqa: PLC0415

    with naming_options({"port": "--foxglove"}):
        server = RigServer(machine, port=port)
    with server:
        _print_address(machine.name, server.address, server.link)
        yield server.follow


def _print_address(name: str, address: str, link: str) -> None:
    typer.echo(f"{name} is at {address} for Foxglove (Open connection), or at the link below; Ctrl-C ends it")
    typer.echo(link)


def _write_file(data: "xarray.Dataset", out: Path, machine: str | None) -> None:
    """Write a run or log as MCAP, and print the path."""
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.foxglove import write_mcap  # noqa: PLC0415

    if out.suffix != ".mcap":
        raise InputError(f"{out.name!r} has an unknown format", where="--out", right="give a name such as run.mcap")
    check_file(out)
    with naming_options(OPTIONS), busy("writing"):
        write_mcap(data, out, machine=machine)
    typer.echo(f"wrote {out}")


def _read(log: Path, mapping: Path | None, machine: str | None) -> "xarray.Dataset":
    """Return a run, a rig's log or a bench log as a data set with the names of a simulated run.

    Raises:
        InputError: it is none of them, or its columns need a mapping.
    """
    from layflat.identify.logs import read_log, read_table  # noqa: PLC0415
    from layflat.rig.recorder.run import ForeignLogError, read_run  # noqa: PLC0415
    from layflat.sim.dataset import open_run  # noqa: PLC0415

    if mapping is None and log.suffix == ".nc":
        run = open_run(log)
        if "time" in run.coords:
            return run
    if mapping is None and log.suffix == ".mcap":
        try:
            with busy("reading"):
                return read_run(log)
        except ForeignLogError:
            pass  # of a test bench
    from layflat.machine import load  # noqa: PLC0415

    with bar("reading", 1.0, "TimeRemainingColumn") as update:
        table = read_table(log, lambda fraction: update(completed=fraction))
    with naming_options({"joints": "--machine"}):
        return read_log(table, mapping, joints=list(load(machine).joints) if machine is not None else None)
