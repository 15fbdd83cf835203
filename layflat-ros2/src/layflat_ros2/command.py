"""Command `layflat-ros2`."""

from pathlib import Path
from typing import Annotated, NoReturn

import typer

from layflat import extras
from layflat.cli.common import MachineName, naming_options
from layflat.cli.rig import FAULT_EXIT, Address, driver_at, stopping
from layflat.errors import LayflatError
from layflat.files import check_folder
from layflat.machine import load
from layflat.rig.recorded import RecordedSession
from layflat.rig.session import RigLoopError
from layflat.rig.system import require_posix
from layflat_ros2.node import RigNode, check_options
from layflat_ros2.rosbridge import Rosbridge

OPTIONS = {name: f"--{name}" for name in ("rosbridge", "namespace", "rate")}
MISTAKE_EXIT = 2  # exit status of a wrong argument

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def serve(
    machine: MachineName,
    driver: Address,
    rosbridge: Annotated[str, typer.Option(help="address of the rosbridge server")] = "ws://localhost:9090",
    namespace: Annotated[str, typer.Option(help="beginning of the names of topics, services and action")] = "/layflat",
    rate: Annotated[float, typer.Option(help="joint states a second, 0.1 to 200")] = 50.0,
    out: Annotated[Path, typer.Option("--out", "-o", help="folder of the log")] = Path("build/ros2"),
) -> None:
    """Serve a rig, real or virtual, to ROS 2 until Ctrl-C, which stops it and vents the air."""
    require_posix("layflat-ros2")
    extras.require("rig", "mcap", "mcap_ros2", where="layflat-ros2")
    with naming_options(OPTIONS):
        check_options(namespace, rate)
        described = load(machine)
        factory, name = driver_at(driver, described)
        check_folder(out)
        with stopping() as stopped, Rosbridge(rosbridge) as link:
            with RecordedSession.in_folder(described, factory, name, out, f"{described.name}-rig") as rig:
                node = RigNode(
                    described, rig.session, link, namespace=namespace, rate=rate, hardware=name, report=_report
                )
                typer.echo(f"{described.name} is at {rosbridge} as {namespace}; Ctrl-C ends it")
                node.run(stopped)
            typer.echo(f"wrote {rig.place}")


def main() -> None:
    """Run the command: a mistake is one line on stderr with exit status 2, a loop that ended one with 3."""
    try:
        app()
    except RigLoopError as error:
        _fail(error, FAULT_EXIT)
    except LayflatError as error:
        _fail(error, MISTAKE_EXIT)


def _report(line: str) -> None:
    typer.echo(line, err=True)


def _fail(error: LayflatError, status: int) -> NoReturn:
    typer.echo(f"layflat-ros2: {error}", err=True)
    raise SystemExit(status)
