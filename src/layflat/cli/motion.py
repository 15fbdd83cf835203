"""Commands that list, show and plan motions of an arm."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.common import MachineName, Out, print_table
from layflat.cli.completers import complete_name
from layflat.cli.groups import motions

if TYPE_CHECKING:
    from layflat.motion.plan import MotionPlan


@motions.register("list", "")
def list_motions() -> None:
    """List the built-in motions."""
    from layflat.motion.file import MOTION_LIBRARY, read_motion  # noqa: PLC0415

    print_table(["motion", "what it is"], [[one, read_motion(one).title] for one in MOTION_LIBRARY.names])


@motions.register("show", "tour > motion.toml")
def show_motion(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="built-in motion", autocompletion=complete_name("motion", files=False))
    ],
) -> None:
    """Print the file of a motion, to start from."""
    from layflat.motion.file import MOTION_LIBRARY  # noqa: PLC0415

    typer.echo(MOTION_LIBRARY.text(name), nl=False)


@motions.register("plan", "tour paper-arm-fast", "motion.toml mine.toml")
def plan_arm_motion(
    file: Annotated[
        str,
        typer.Argument(
            metavar="NAME|FILE", help="built-in motion, or segments in TOML", autocompletion=complete_name("motion")
        ),
    ],
    machine: MachineName,
    out: Out = Path("build/motion"),
) -> None:
    """Plan a motion of a machine's arm.

    A plan is demands over time, with velocities and accelerations. Prints what each segment asks of the arm; writes
    NAME-demand.csv and NAME-motion.png, after the motion's name.
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
    demand = _write_plan(plan, out / f"{described.name}-demand.csv", out / f"{described.name}-motion.png")
    typer.echo(f"follow it with `layflat simulate {machine} --demand {demand}`")


def _write_plan(plan: "MotionPlan", demand: Path, figure: Path) -> Path:
    """Write the demands and the figure of a motion, print both paths, and return that of the demands."""
    from layflat.motion.demand_file import write_demand  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415

    cycle = plan.machine.cycle
    q, v, a = plan.trajectory.rows(cycle)
    write_demand(plan.machine, plan.trajectory.times(cycle), q, demand, velocity=v, acceleration=a)
    typer.echo(f"wrote {demand}")
    typer.echo(f"wrote {save_figure(plan.plot(), figure)}")
    return demand


def _print_segments(plan: "MotionPlan", title: str) -> None:
    """Print the demand of each segment on the arm, and the belts that leave its reach."""
    from layflat.motion.plan import SEGMENT_COLUMNS  # noqa: PLC0415

    summary = f"{title}: {plan.trajectory.duration:.3f} s, payload {plan.payload:g} kg"
    print_table(list(SEGMENT_COLUMNS), plan.segment_rows(), summary)
    for number, segment in enumerate(plan.segments, 1):
        if segment.reach_exit is not None:
            at = ", ".join(
                f"{axis} = {1e3 * of:.0f} mm" for axis, of in zip("xyz", segment.reach_exit.position, strict=False)
            )
            place = f"at {at}, {segment.reach_exit.time:.3f} s after it began"
            typer.echo(f"segment {number}: its target leaves the arm's reach {place}; the arm stops there")
