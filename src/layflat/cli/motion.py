"""Commands about motions of an arm: motions, motion."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import MachineName, Out, app, print_table

if TYPE_CHECKING:
    from layflat.motion.plan import Plan


@app.command()
def motions(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="print its file, to start from")] = None,
) -> None:
    """List the built-in motions, or print one."""
    from layflat.motion.file import MOTIONS, read_motion  # noqa: PLC0415

    if name is not None:
        typer.echo(MOTIONS.text(name), nl=False)
        return
    print_table(["motion", "what it is"], [[one, read_motion(one).title] for one in MOTIONS.names])


@app.command()
def motion(
    file: Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in motion, or segments in TOML")],
    machine: MachineName,
    out: Out = Path("build/motion"),
) -> None:
    """Plan a motion of a machine's arm: demands over time, with velocities and accelerations.

    Prints what each segment asks of the arm; writes NAME-demand.csv and NAME-motion.png, after the motion's name.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.motion.demand_file import check_row_count  # noqa: PLC0415
    from layflat.motion.file import read_motion  # noqa: PLC0415
    from layflat.motion.plan import plan_motion  # noqa: PLC0415

    described, moved = read_motion(file), load(machine)
    plan = plan_motion(moved, described)
    check_row_count(plan.trajectory.cycles(moved.cycle), moved.cycle, described.origin)
    check_folder(out, f"{described.name}-demand.csv", f"{described.name}-motion.png")
    _print_segments(plan, f"{described.name} on {moved.name}")
    demand = _write(plan, out / f"{described.name}-demand.csv", out / f"{described.name}-motion.png")
    typer.echo(f"follow it with `layflat simulate {machine} --demand {demand}`")


def _write(plan: "Plan", demand: Path, figure: Path) -> Path:
    """Write the demands and the figure of a motion, and return where the demands are."""
    from layflat.motion.demand_file import write_demand  # noqa: PLC0415
    from layflat.motion.picture import picture  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415

    cycle = plan.machine.cycle
    q, v, a = plan.trajectory.rows(cycle)
    write_demand(plan.machine, plan.trajectory.times(cycle), q, demand, velocity=v, acceleration=a)
    typer.echo(f"wrote {demand}")
    typer.echo(f"wrote {save(picture(plan), figure)}")
    return demand


def _print_segments(plan: "Plan", title: str) -> None:
    """Print what each segment asks of the arm, and which belts leave its reach."""
    rows = []
    for number, (begin, segment) in enumerate(zip(plan.trajectory.begins, plan.segments, strict=True), 1):
        asked = plan.asked(segment)
        times = f"{begin:.3f}", f"{segment.motion.duration:.3f}"
        rows.append(
            [f"{number} {segment.kind}", *times, f"{asked.tip_speed:.2f}", f"{asked.torque:.0%} ({asked.joint})"]
        )
    columns = ["segment", "from (s)", "duration (s)", "peak tip speed (m/s)", "peak torque share (joint)"]
    print_table(columns, rows, f"{title}: {plan.trajectory.duration:.3f} s, payload {plan.payload:g} kg")
    for number, segment in enumerate(plan.segments, 1):
        if segment.left is not None:
            at = ", ".join(f"{axis} = {1e3 * of:.0f} mm" for axis, of in zip("xyz", segment.left.place, strict=False))
            place = f"at {at}, {segment.left.time:.3f} s after it began"
            typer.echo(f"segment {number}: its target leaves the arm's reach {place}; the arm stops there")
