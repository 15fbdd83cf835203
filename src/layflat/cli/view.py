"""Command that shows an arm in space."""

from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import busy
from layflat.cli.common import MachineName, naming_options
from layflat.cli.groups import arms
from layflat.cli.pages import print_link
from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.bridge.view.browser import PlayedMotion
    from layflat.machine import Machine


@arms.register("view", "picking-arm", "picking-arm --run build/simulate/picking-arm.nc", "picking-arm --png arm.png")
def view_arm(
    machine: MachineName,
    run: Annotated[Path | None, typer.Option(metavar="RUN", help="play a run of the machine, NetCDF")] = None,
    png: Annotated[Path | None, typer.Option(metavar="FILE", help="draw a picture instead, without a screen")] = None,
    pose: Annotated[
        str | None, typer.Option(help='angles, such as "20 deg, 0 deg"  [default: mid-stroke; with --png: end of RUN]')
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="of the page; 0 is any that is free")] = 8080,
) -> None:
    """Show a machine's arm in the browser, or draw a picture.

    The page plays a run from its start; a picture shows the path of its tip. Squares of the floor are 100 mm. The page
    is for browsers on this computer, until Ctrl-C.
    """
    from layflat import extras  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    extras.require("view", *(("mujoco", "PIL") if png else ("viser",)), where="arm view")
    described = load(machine)
    motion = None if run is None else _run_motion(described, run)
    angles = [0.0] * len(described.joints) if motion is None else motion.angles[-1 if png else 0].tolist()
    if pose is not None:
        angles = _parse_pose(described, pose)
    if png is not None:
        _write_picture(described, angles, png, motion)
        return
    _serve_view(described, angles, motion, port)


def _write_picture(machine: "Machine", angles: list[float], png: Path, motion: "PlayedMotion | None") -> None:
    """Write the picture of an arm at angles (rad), with the tip's path of a motion, and print the file's path.

    Raise InputError unless it ends in .png.
    """
    from layflat.bridge.view.picture import save_picture  # noqa: PLC0415
    from layflat.files import check_file  # noqa: PLC0415

    if png.suffix.lower() != ".png":
        raise InputError(f"{png.name!r} has an unknown format", where="--png", right="give a name such as arm.png")
    check_file(png)
    tip_path = () if motion is None else motion.angles
    typer.echo(f"wrote {save_picture(machine, angles, png, motion=tip_path)}")


def _serve_view(machine: "Machine", angles: list[float], motion: "PlayedMotion | None", port: int) -> None:
    """Serve the page of an arm at angles (rad) until Ctrl-C."""
    from layflat.bridge.view.browser import Viewer  # noqa: PLC0415
    from layflat.cli.rig import stopping  # noqa: PLC0415

    with stopping() as stopped, naming_options({"port": "--port"}):
        with busy("starting"):
            viewer = Viewer(machine, angles, motion=motion, port=port)
        with viewer:
            print_link(machine.name, viewer.address)
            viewer.serve(stopped)


def _parse_pose(machine: "Machine", text: str) -> list[float]:
    """Return the angles (rad) of the option --pose, one for each joint.

    Raise InputError for another number of values, or one beyond the joint's stops.
    """
    from layflat.description import units as u  # noqa: PLC0415

    parts = [part.strip() for part in text.split(",")]
    if len(parts) != len(machine.joints):
        names = ", ".join(machine.joints)
        raise InputError(f"{text!r} has {len(parts)} values", where="--pose", right=f"give one for each of {names}")
    angles = [u.quantity(part, u.ANGLE, "--pose") for part in parts]
    for (name, joint), angle in zip(machine.joints.items(), angles, strict=True):
        stop = joint.stops.mechanical_stroke / 2
        if abs(angle) > stop + radians(1e-9):
            what = f"{degrees(angle):.6g} deg is beyond the stops of joint {name!r}"
            raise InputError(what, where="--pose", right=f"stay within +-{degrees(stop):.6g} deg")
    return angles


def _run_motion(machine: "Machine", run: Path) -> "PlayedMotion":
    """Return the motion of the arm in a run; raise InputError if it has no angles, or those of other joints."""
    from layflat.bridge.view.browser import PlayedMotion  # noqa: PLC0415
    from layflat.sim.dataset import open_run  # noqa: PLC0415

    dataset = open_run(run)
    if not {"angle", "time", "joint"} <= set(dataset.variables):
        raise InputError("has no angles of joints over time", where=str(run), right="give a run of `layflat simulate`")
    joints = [str(name) for name in dataset["joint"].values]
    if joints != list(machine.joints):
        right = f"give one of joints {', '.join(machine.joints)}"
        raise InputError(f"is of an arm with the joints {', '.join(joints)}", where=str(run), right=right)
    return PlayedMotion(dataset["time"].values, dataset["angle"].transpose("time", "joint").values)
