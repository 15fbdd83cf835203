"""Commands that import and export arms as robot files."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from layflat.cli.common import MachineName, Out, expanded, naming_options, print_table
from layflat.cli.groups import arms
from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.bridge.robots import ImportedArm

Value = TypeVar("Value")

IMPORT_OPTIONS = {name: f"--{name}" for name in ("joints", "to", "tool", "name", "stroke", "gravity")} | {
    "base": "--from",
    "packages": "--package",
    "meshes=True": "--meshes",
    "meshes=False": "--no-meshes",
}
"""Options of an import by its arguments."""


@arms.register("export", "picking-arm --out arm.xml", "picking-arm --out arm.urdf --ros2-control")
def export_arm(
    machine: MachineName,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="ends in .xml (MJCF) or .urdf")],
    ros2_control: Annotated[
        bool, typer.Option("--ros2-control", help="with the block by which controllers of ROS 2 drive the joints")
    ] = False,
) -> None:
    """Export a machine's arm as MJCF (MuJoCo) or URDF.

    Meshes go to a folder beside the file.
    """
    from layflat.bridge import save_arm  # noqa: PLC0415
    from layflat.bridge.arm import conversion_losses  # noqa: PLC0415
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    described = load(machine)
    check_file(out)
    with naming_options({"path": "--out", "ros2_control": "--ros2-control"}):
        written = save_arm(described, out, ros2_control=ros2_control)
    for line in conversion_losses(described, out.suffix):
        typer.echo(line)
    for path in written:
        typer.echo(f"wrote {path}")


@dataclass(frozen=True)
class RobotOptions:
    """Options about the robot that an arm is imported from (see `expanded`)."""

    joints: Annotated[
        list[str] | None,
        typer.Option(help='joints of hose: MACHINE:JOINT, or "NAME=MACHINE:JOINT" for one of the arm\'s; repeatable'),
    ] = None
    base: Annotated[
        str, typer.Option("--from", metavar="LINK", help="that the arm stands on, held still  [default: the base]")
    ] = ""
    to: Annotated[str, typer.Option(metavar="LINK", help="where the arm ends, in a robot with several")] = ""
    tool: Annotated[str, typer.Option(metavar="FRAME", help="link, body or site at the tip")] = ""
    stroke: Annotated[
        list[str] | None, typer.Option(help='limits of a joint, such as "wrist=-60 deg, 60 deg"; repeatable')
    ] = None
    gravity: Annotated[str, typer.Option(help='such as "0, 0, -9.81 m/s^2"  [default: the file\'s, or against z]')] = ""


@arms.register("import", "robot.urdf", 'robot.urdf --stroke "wrist=-60 deg, 60 deg"')
@expanded
def import_robot(
    file: Annotated[Path, typer.Argument(metavar="ROBOT", help="URDF or MJCF")],
    robot: RobotOptions,
    name: Annotated[str, typer.Option(help="of the machine  [default: the robot's]")] = "",
    meshes: Annotated[bool, typer.Option(help="whether to draw links by the robot's meshes")] = True,
    package: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=FOLDER", help="where a ROS package is whose meshes a URDF names; repeatable"),
    ] = None,
    out: Out = Path("build/arm"),
) -> None:
    """Import an arm from URDF or MJCF.

    Joints of hose take the place of its own. Prints what its joints are; writes NAME.toml, a description that
    simulates as it is, and meshes beside it.
    """
    from layflat.bridge.robots import ChainEnds, import_arm  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    limits = _unique_values([_parse_stroke(text) for text in robot.stroke or []], "--stroke")
    folders = _unique_values([_parse_package(text) for text in package or []], "--package")
    pull = _parse_gravity(robot.gravity) if robot.gravity else None
    with naming_options(IMPORT_OPTIONS):
        imported = import_arm(
            file,
            joints=robot.joints or [],
            ends=ChainEnds(robot.base, robot.to, robot.tool),
            name=name,
            stroke=limits,
            gravity=pull,
            meshes=meshes,
            packages=folders,
        )
    check_folder(out, f"{imported.machine.name}.toml")
    _print_arm(imported)
    for path in imported.save(out):
        typer.echo(f"wrote {path}")


def _print_arm(imported: "ImportedArm") -> None:
    """Print a table of an imported arm's joints, and its notes."""
    from math import degrees  # noqa: PLC0415

    machine, rows = imported.machine, []
    for name, turn, torque, weight in zip(
        machine.joints, imported.turning, imported.torques, imported.weights, strict=True
    ):
        angles = f"{degrees(turn.middle):.1f}", f"{degrees(turn.works):.1f}", f"{degrees(turn.mechanical):.1f}"
        rows.append([name, *angles, f"{torque:.2f}", f"{weight:.2f}"])
    columns = ["joint", "zero at (deg)", "working stroke (deg)", "stops (deg)", "torque (N m)", "gravity (N m)"]
    chain = imported.chain
    print_table(columns, rows, f"{machine.name}: {machine.title}; tip at {chain.tool_name}, {chain.payload:g} kg there")
    for note in imported.notes():
        typer.echo(note)


def _parse_stroke(text: str) -> tuple[str, tuple[float, float]]:
    """Return joint and limits (rad) of a text such as "wrist=-60 deg, 60 deg"; raise InputError for any other."""
    from layflat.description import units as u  # noqa: PLC0415

    name, _, limits = text.rpartition("=")
    parts = [one.strip() for one in limits.split(",") if one.strip()] if name.strip() else []
    both = [u.quantity(one, u.ANGLE, "--stroke") for one in parts]
    if len(both) != 2 or both[0] >= both[1]:
        what = f"{text!r} has no joint with two limits, the lower first"
        raise InputError(what, where="--stroke", right='give such as "wrist=-60 deg, 60 deg"')
    return name.strip(), (both[0], both[1])


def _parse_package(text: str) -> tuple[str, Path]:
    """Return name and folder of an option such as "my_robot=/opt/my_robot"; raise InputError if there is none."""
    name, _, folder = text.partition("=")
    if not name.strip() or not folder.strip():
        right = "give NAME=FOLDER, such as my_robot=../my_robot"
        raise InputError(f"{text!r} names no folder", where="--package", right=right)
    path = Path(folder.strip())
    if not path.is_dir():
        raise InputError(f"there is no folder {str(path)!r}", where="--package", right="give the package's own folder")
    return name.strip(), path


def _unique_values(pairs: list[tuple[str, Value]], option: str) -> dict[str, Value]:
    """Return values by name; raise InputError for a name that occurs twice."""
    values: dict[str, Value] = {}
    for name, value in pairs:
        if name in values:
            raise InputError(f"{name!r} is given twice", where=option, right="give it once")
        values[name] = value
    return values


def _parse_gravity(text: str) -> list[float]:
    """Return the three components (m/s2) of an option such as "0, 0, -9.81 m/s^2"; zeros need no unit.

    Raise InputError for another number of values, or a value that is no acceleration.
    """
    from layflat.description import units as u  # noqa: PLC0415

    parts = [one.strip() for one in text.split(",")]
    if len(parts) != 3:
        raise InputError(f"{text!r} has {len(parts)} values", where="--gravity", right='give "0, 0, -9.81 m/s^2"')
    return [0.0 if _is_zero(one) else u.quantity(one, u.ACCELERATION, "--gravity") for one in parts]


def _is_zero(text: str) -> bool:
    """Return whether a text is a number equal to zero."""
    try:
        return float(text) == 0.0
    except ValueError:
        return False
