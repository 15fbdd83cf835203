"""Commands that size arms: size-arm, arm-tasks."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.app import Out, app, expanded, print_findings, print_table
from layflat.cli.bars import bar
from layflat.cli.design import say_what_is_left_out
from layflat.errors import InputError, StoppedError

if TYPE_CHECKING:
    from layflat.design.arm.sizing import SizedArm

PLACE = "such as '500 mm, 0 mm, 300 mm'"


@app.command()
def arm_tasks(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="print its file, to start from")] = None,
) -> None:
    """List the built-in tasks of arms, or print one."""
    from layflat.design.arm.task import TASKS, read_task  # noqa: PLC0415

    if name is not None:
        typer.echo(TASKS.text(name), nl=False)
        return
    print_table(["task", "what it is"], [[one, read_task(one).title] for one in TASKS.names])


@dataclass(frozen=True)
class Asked:
    """Options that say what an arm is to do; each stands over what the file says."""

    reach: Annotated[str | None, typer.Option(help='of a standard arm, from shoulder to payload, such as "0.9 m"')] = (
        None
    )
    joints: Annotated[int | None, typer.Option(help="of a standard arm: 1 to 4; default: 4")] = None
    payload: Annotated[str | None, typer.Option(help='the greatest, such as "1 kg"')] = None
    supply: Annotated[str | None, typer.Option(help='gauge pressure of the supply, such as "6 bar"')] = None
    time: Annotated[str | None, typer.Option(help="of a move from rest to rest: half of a cycle there and back")] = None
    acceleration: Annotated[str | None, typer.Option(help="of the tip, in place of --time")] = None
    turn: Annotated[str | None, typer.Option(help="of the joint that turns most in a move; default: 60 deg")] = None
    volume: Annotated[
        str | None, typer.Option(metavar="LOW to HIGH", help=f"box in which the tip moves: two corners {PLACE}")
    ] = None
    point: Annotated[
        list[str] | None, typer.Option(metavar="X, Y, Z", help=f"that the tip goes to, in turn, {PLACE}; repeat it")
    ] = None
    pose: Annotated[
        list[str] | None, typer.Option(metavar="ANGLES", help="one a joint from mid-stroke, gone to in turn; repeat it")
    ] = None
    margin: Annotated[float | None, typer.Option(help="of what joints can do over what moves ask; default: 1.3")] = None
    name: Annotated[str | None, typer.Option(help="of the arm and its files; default: the task's")] = None

    def told(self) -> dict[str, Any]:
        """Return what was given, by the keys of a task's file."""
        given = asdict(self) | {"points": None, "poses": None}
        for one, several in (("point", "points"), ("pose", "poses")):
            rows = given.pop(one)
            given[several] = [_listed(row) for row in rows] if rows else None
        if self.volume is not None:
            low, to, high = self.volume.partition(" to ")
            if not to:
                right = 'give two corners, such as "0.4 m, -0.3 m, 0 m to 0.7 m, 0.3 m, 0.5 m"'
                raise InputError(f"{self.volume!r} is no box", where="--volume", right=right)
            given["volume"] = {"low": _listed(low), "high": _listed(high)}
        return given


@app.command()
@expanded
def size_arm(
    asked: Asked,
    task: Annotated[
        str | None, typer.Argument(metavar="TASK|FILE", help="built-in task (see arm-tasks), or one in TOML")
    ] = None,
    pareto: Annotated[
        bool, typer.Option("--pareto", help="size it at other pressures and speeds too; draw mass against time")
    ] = False,
    pressures: Annotated[str | None, typer.Option(help='of --pareto, such as "4 bar, 6 bar"; default: 2 to 8 bar')] = (
        None
    ),
    times: Annotated[
        str | None,
        typer.Option(help='of a move, of --pareto, such as "0.5 s, 1 s"; default: 0.7 to 2.4 of the task\'s'),
    ] = None,
    out: Out = Path("build/size-arm"),
) -> None:
    """Size an arm from what it is to do: joints, links and masses that carry it with margin.

    Writes a complete description that can be simulated, a picture of the arm, and its joints' drawings.
    """
    from layflat.design import write_drawings  # noqa: PLC0415
    from layflat.design.arm.picture import arm_picture  # noqa: PLC0415
    from layflat.design.arm.sizing import size_arm  # noqa: PLC0415
    from layflat.design.arm.task import read_task  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415

    told = asked.told()
    if task is None and not any(value is not None for value in told.values()):
        right = "see `layflat arm-tasks`, or give --reach, --payload, --supply and --time"
        raise InputError("is missing", where="size-arm: TASK", right=right)
    grid = _grid(pareto, pressures, times)
    described = read_task(task, **told)
    pareto_names = (f"{described.name}-pareto.csv", f"{described.name}-pareto.png") if pareto else ()
    check_folder(out, f"{described.name}.toml", f"{described.name}-arm.png", *pareto_names)
    with bar(f"sizing {described.name}", None, "TimeElapsedColumn") as update:
        arm = size_arm(described, tell=lambda rounds: update(description=f"sizing {described.name}, round {rounds}"))
    say_what_is_left_out()
    _print(arm)
    path = arm.write(out / f"{described.name}.toml")
    typer.echo(f"wrote {path}")
    typer.echo(f"wrote {save(arm_picture(arm), out / f'{described.name}-arm.png')}")
    for design in arm.designs:
        for drawing in write_drawings(design, out):
            typer.echo(f"wrote {drawing}")
    if pareto:
        _compare(arm, *grid, out)
    typer.echo(f"simulate it with `layflat simulate {path}`")


def _listed(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _print(arm: "SizedArm") -> None:
    """Print what joints give and weigh, of what they and their links are made, and findings."""
    from layflat.design.arm.links import WALL  # noqa: PLC0415

    task, (least, most) = arm.task, (f"{time:.2f}" for time in (arm.moves.times.min(), arm.moves.times.max()))
    strengths, made = [], []
    for part, need, asked in zip(arm.parts, arm.needs, arm.wanted, strict=True):
        name, joint = part.task.name, arm.machine.joint[part.task.name]
        torques = (need.static, need.torque, asked, part.torque)
        flow = part.valve.nominal_flow if part.valve else 0.0
        strengths.append([name, *(f"{torque:.1f}" for torque in torques), f"{flow:.0f}", f"{part.mass:.2f}"])
        strap = joint.strap
        straps = f"{strap.layers} x {1e3 * strap.width:.0f} x {1e3 * strap.thickness:g}"
        cylinder = f"{1e3 * joint.cylinder.diameter:.0f} x {1e3 * joint.cylinder.wall:g}"
        sizes = [f"{1e3 * joint.hose.width:.0f}", cylinder, f"{1e3 * joint.output.radius:.1f}", straps]
        tube = part.tube
        link = [f"{1e3 * tube.length:.0f}", f"{1e3 * tube.diameter:.0f} x {1e3 * WALL:g}", f"{tube.mass:.2f}"]
        made.append([name, *sizes, *link])
    columns = ["joint", "holds (N m)", "moves (N m)", "with margin (N m)", "gives (N m)", "valve (l/min)", "mass (kg)"]
    times = least if least == most else f"{least} to {most}"
    title = f"{task.name}: {task.payload:.3g} kg, moves of {times} s, {task.supply / 1e5:g} bar"
    print_table(columns, strengths, title)
    columns = ["joint", "hose (mm)", "cylinder (mm)", "cam (mm)", "straps (mm)"]
    print_table([*columns, "link (mm)", "its tube (mm)", "its mass (kg)"], made)
    joints = sum(part.mass for part in arm.parts)
    typer.echo(f"mass: {arm.mass:.2f} kg, of which {joints:.2f} kg joints")
    print_findings(arm.findings)


def _grid(pareto: bool, pressures: str | None, times: str | None) -> tuple[list[float], list[float]]:
    """Return pressures (gauge, Pa) and times (s) of a comparison; none where they are not given."""
    from layflat.description import units as u  # noqa: PLC0415

    given = {"--pressures": (pressures, u.PRESSURE), "--times": (times, u.TIME)}
    for option, (text, _) in given.items():
        if text is not None and not pareto:
            raise InputError("needs --pareto", where=option, right="it is what that goes through")
    found = []
    for option, (text, kind) in given.items():
        values = sorted({u.quantity(one, kind, option) for one in _listed(text)}) if text is not None else []
        if values and values[0] <= 0.0:
            raise InputError(f"{text!r} is out of range", where=option, right="give values above zero")
        found.append(values)
    return found[0], found[1]


def _compare(arm: "SizedArm", pressures: list[float], times: list[float], out: Path) -> None:
    """Size the arm's task at other pressures and times of its moves; write a table and the picture."""
    from layflat.design.arm.picture import sizes_picture  # noqa: PLC0415
    from layflat.design.arm.trade_off import PACES, PRESSURES, trade_off, write_trials  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415

    paces = [time / float(arm.moves.times.mean()) for time in times]
    try:
        with bar("sizing it otherwise", None, "MofNCompleteColumn", "TimeRemainingColumn") as update:
            trials = trade_off(
                arm,
                pressures or PRESSURES,
                paces or PACES,
                advance=lambda done, total: update(completed=done, total=total),
            )
    except KeyboardInterrupt:
        raise StoppedError("the arm itself", out) from None
    stem = f"{arm.task.name}-pareto"
    typer.echo(f"wrote {write_trials(trials, out / f'{stem}.csv')}")
    typer.echo(f"wrote {save(sizes_picture(arm, trials), out / f'{stem}.png')}")
    refused = [one for one in trials if one.refused]
    if refused:
        typer.echo(f"{len(refused)} of {len(trials)} are beyond what such joints can do; {stem}.csv says why")
