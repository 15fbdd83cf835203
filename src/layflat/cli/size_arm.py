"""Commands that size arms, and list and show their tasks."""

from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from math import inf, isinf, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.bars import bar
from layflat.cli.common import Out, expanded, naming_options, print_findings, print_table
from layflat.cli.completers import complete_name
from layflat.cli.design import report_missing_dxf
from layflat.cli.groups import arms, tasks
from layflat.errors import DesignError, InputError, StoppedError

if TYPE_CHECKING:
    from layflat.design.arm.sizing import SizedArm
    from layflat.design.arm.trade_off import Totals
    from layflat.solids.cost import Prices

POINT_EXAMPLE = "such as '500 mm, 0 mm, 300 mm'"
TASK_KEYS = {"point": "points", "configuration": "configurations"}  # keys of a task with options of other names


@tasks.register("list", "")
def list_tasks() -> None:
    """List the built-in tasks of arms."""
    from layflat.design.arm import TASK_LIBRARY, read_task  # noqa: PLC0415

    print_table(["task", "what it is"], [[one, read_task(one).title] for one in TASK_LIBRARY.names])


@tasks.register("show", "picking-arm > task.toml")
def show_task(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="built-in task", autocompletion=complete_name("task", files=False))
    ],
) -> None:
    """Print the file of a task, to start from."""
    from layflat.design.arm import TASK_LIBRARY  # noqa: PLC0415

    typer.echo(TASK_LIBRARY.text(name), nl=False)


@dataclass(frozen=True)
class TaskOptions:
    """Options about the task of an arm; each replaces the value of the task's file."""

    reach: Annotated[str | None, typer.Option(help='of a standard arm, from shoulder to payload, such as "0.9 m"')] = (
        None
    )
    joints: Annotated[int | None, typer.Option(help="of a standard arm: 1 to 4; default: 4")] = None
    payload: Annotated[str | None, typer.Option(help='the greatest, such as "1 kg"')] = None
    supply: Annotated[str | None, typer.Option(help='gauge pressure of the supply, such as "6 bar"')] = None
    time: Annotated[str | None, typer.Option(help="of a move from rest to rest: half of a cycle there and back")] = None
    acceleration: Annotated[str | None, typer.Option(help="of the tip, in place of --time")] = None
    rotation: Annotated[str | None, typer.Option(help="of the joint that turns most; default: 60 deg")] = None
    volume: Annotated[
        str | None, typer.Option(metavar="LOW to HIGH", help=f"box in which the tip moves: two corners {POINT_EXAMPLE}")
    ] = None
    point: Annotated[
        list[str] | None,
        typer.Option(metavar="X, Y, Z", help=f"that the tip goes to, in turn, {POINT_EXAMPLE}; repeat it"),
    ] = None
    configuration: Annotated[
        list[str] | None, typer.Option(metavar="ANGLES", help="one a joint from mid-stroke, gone to in turn; repeat it")
    ] = None
    margin: Annotated[float | None, typer.Option(help="of what joints can do over what moves ask; default: 1.3")] = None
    name: Annotated[str | None, typer.Option(help="of the arm and its files; default: the task's")] = None

    def names(self, place: str) -> dict[str, str]:
        """Return the given options by the places of their values in the errors of a task; `place` is the task's."""
        given = [name for name, value in asdict(self).items() if value is not None]
        return {f"{place}: {TASK_KEYS.get(name, name)}": f"--{name}" for name in given}

    def task_values(self) -> dict[str, Any]:
        """Return the values of the options by the keys of a task's file; None where an option is not given.

        Raise InputError for a volume without two corners.
        """
        values = asdict(self) | {"points": None, "configurations": None}
        for option, key in TASK_KEYS.items():
            rows = values.pop(option)
            values[key] = [_listed(row) for row in rows] if rows else None
        if self.volume is not None:
            low, to, high = self.volume.partition(" to ")
            if not to:
                right = 'give two corners, such as "0.4 m, -0.3 m, 0 m to 0.7 m, 0.3 m, 0.5 m"'
                raise InputError(f"{self.volume!r} is no box", where="--volume", right=right)
            values["volume"] = {"low": _listed(low), "high": _listed(high)}
        return values


@dataclass(frozen=True)
class ComparisonOptions:
    """Options about the comparison of an arm with others for the same task."""

    pareto: Annotated[
        bool, typer.Option("--pareto", help="size it at other pressures and speeds too; draw mass against time")
    ] = False
    pressures: Annotated[str | None, typer.Option(help='of --pareto, such as "4 bar, 6 bar"; default: 2 to 8 bar')] = (
        None
    )
    times: Annotated[
        str | None,
        typer.Option(help='of a move, of --pareto, such as "0.5 s, 1 s"; default: 0.7 to 2.4 of the task\'s'),
    ] = None
    built: Annotated[
        bool, typer.Option("--built", help="--pareto compares arms by the masses of what `layflat build` would make")
    ] = False
    prices: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="prices as of `layflat build`: as --built, and --pareto compares costs too"),
    ] = None

    def grid(self) -> tuple[list[float], list[float]]:
        """Return pressures (gauge, Pa) and times (s), ascending; empty where an option is not given.

        Raise InputError for an option without --pareto, or a value that is not above zero.
        """
        from layflat.description import units as u  # noqa: PLC0415

        given = {f"--{name}": value for name, value in asdict(self).items() if value not in (None, False)}
        if given and not self.pareto:
            raise InputError("needs --pareto", where=next(iter(given)), right="add it, or leave this option out")
        grid = []
        for option, text, kind in (("--pressures", self.pressures, u.PRESSURE), ("--times", self.times, u.TIME)):
            values = sorted({u.quantity(one, kind, option) for one in _listed(text)}) if text is not None else []
            if values and values[0] <= 0.0:
                raise InputError(f"{text!r} is out of range", where=option, right="give values above zero")
            grid.append(values)
        return grid[0], grid[1]

    def totals(self, prices: "Prices | None") -> "Totals | None":
        """Return the function that returns mass and cost of an arm as built; None without --built and --prices."""
        if not self.built and prices is None:
            return None
        from layflat.solids.totals import built_totals  # noqa: PLC0415

        return partial(built_totals, prices=prices)

    def read_prices(self) -> "Prices | None":
        """Return the prices of --prices; raise InputError if the file is wrong."""
        from layflat.solids.cost import read_prices  # noqa: PLC0415

        return None if self.prices is None else read_prices(self.prices)


@arms.register(
    "size",
    "picking-arm",
    "--reach 900mm --payload 1kg --supply 6bar --time 0.6s",
    "picking-arm --pareto --prices prices.toml",
)
@expanded
def size_for_task(
    options: TaskOptions,
    comparison: ComparisonOptions,
    task: Annotated[
        str | None,
        typer.Argument(
            metavar="TASK|FILE",
            help="built-in task (see `layflat task list`), or one in TOML",
            autocompletion=complete_name("task"),
        ),
    ] = None,
    out: Out = Path("build/size-arm"),
) -> None:
    """Size an arm from its task: joints, links and masses.

    They carry the payload with margin. Writes a complete description that can be simulated, a picture of the arm, and
    its joints' drawings.
    """
    from layflat.design import write_drawings  # noqa: PLC0415
    from layflat.design.arm import read_task  # noqa: PLC0415
    from layflat.design.arm.sizing import size_arm  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415

    values = options.task_values()
    if task is None and not any(value is not None for value in values.values()):
        right = "see `layflat task list`, or give --reach, --payload, --supply and --time"
        raise InputError("is missing", where="arm size: TASK", right=right)
    grid, prices = comparison.grid(), comparison.read_prices()
    with naming_options(options.names("task" if task is None else task)):
        described = read_task(task, **values)
    pareto_names = (f"{described.name}-pareto.csv", f"{described.name}-pareto.png") if comparison.pareto else ()
    check_folder(out, f"{described.name}.toml", f"{described.name}-arm.png", *pareto_names)
    with bar(f"sizing {described.name}", None, "TimeElapsedColumn") as update:
        arm = size_arm(
            described, progress=lambda rounds: update(description=f"sizing {described.name}, round {rounds}")
        )
    report_missing_dxf()
    _print(arm)
    path = arm.write(out / f"{described.name}.toml")
    typer.echo(f"wrote {path}")
    typer.echo(f"wrote {save_figure(arm.plot(), out / f'{described.name}-arm.png')}")
    for design in arm.designs:
        for drawing in write_drawings(design, out):
            typer.echo(f"wrote {drawing}")
    if comparison.pareto:
        _compare(arm, grid, comparison.totals(prices), out)
        _report_unpriced(arm, prices)
    typer.echo(f"simulate it with `layflat simulate {path}`")


def _listed(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _print(arm: "SizedArm") -> None:
    """Print torques and masses of the joints, dimensions of joints and links, and the findings of the design rules."""
    from layflat.design.arm.components import WALL_THICKNESS  # noqa: PLC0415

    task, (shortest, longest) = arm.task, (f"{time:.2f}" for time in (arm.moves.times.min(), arm.moves.times.max()))
    strengths, dimensions = [], []
    for part, need, with_margin in zip(arm.parts, arm.needs, arm.required_torques, strict=True):
        name, joint = part.task.name, arm.machine.joint[part.task.name]
        torques = (need.static, need.torque, with_margin, part.torque)
        flow = part.valve.nominal_flow if part.valve else 0.0
        strengths.append([name, *(f"{torque:.1f}" for torque in torques), f"{flow:.0f}", f"{part.mass:.2f}"])
        strap = joint.strap
        straps = f"{strap.layers} x {1e3 * strap.width:.0f} x {1e3 * strap.thickness:g}"
        cylinder = f"{1e3 * joint.cylinder.diameter:.0f} x {1e3 * joint.cylinder.wall:g}"
        sizes = [f"{1e3 * joint.hose.width:.0f}", cylinder, f"{1e3 * joint.output.radius:.1f}", straps]
        tube = part.tube
        link = [f"{1e3 * tube.length:.0f}", f"{1e3 * tube.diameter:.0f} x {1e3 * WALL_THICKNESS:g}", f"{tube.mass:.2f}"]
        dimensions.append([name, *sizes, *link])
    columns = ["joint", "holds (N m)", "moves (N m)", "with margin (N m)", "gives (N m)", "valve (l/min)", "mass (kg)"]
    times = shortest if shortest == longest else f"{shortest} to {longest}"
    title = f"{task.name}: {task.payload:.3g} kg, moves of {times} s, {task.supply / 1e5:g} bar"
    print_table(columns, strengths, title)
    columns = ["joint", "hose (mm)", "cylinder (mm)", "cam (mm)", "straps (mm)"]
    print_table([*columns, "link (mm)", "its tube (mm)", "its mass (kg)"], dimensions)
    joints = sum(part.mass for part in arm.parts)
    typer.echo(f"mass: {arm.mass:.2f} kg, of which {joints:.2f} kg joints")
    print_findings(arm.findings)


def _compare(arm: "SizedArm", grid: tuple[list[float], list[float]], totals: "Totals | None", out: Path) -> None:
    """Size the arm's task at other pressures and times of its moves; write a table and the picture, print their paths.

    Empty lists stand for the defaults. Raise StoppedError after Ctrl-C.
    """
    from layflat.design.arm.trade_off import PACE_RATIOS, PRESSURES, sizes_picture, trade_off, write_trials  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415

    pressures, times = grid
    paces = [time / float(arm.moves.times.mean()) for time in times]
    try:
        with bar("sizing it otherwise", None, "MofNCompleteColumn", "TimeRemainingColumn") as update:
            trials = trade_off(
                arm,
                pressures or PRESSURES,
                paces or PACE_RATIOS,
                totals=totals,
                advance=lambda done, total: update(completed=done, total=total),
            )
    except KeyboardInterrupt:
        raise StoppedError("the arm itself", out) from None
    stem = f"{arm.task.name}-pareto"
    built = None if totals is None else _print_totals(arm, totals)
    typer.echo(f"wrote {write_trials(trials, out / f'{stem}.csv')}")
    typer.echo(f"wrote {save_figure(sizes_picture(arm, trials, built), out / f'{stem}.png')}")
    beyond = [one for one in trials if isinf(one.mass)]
    unbuilt = [one for one in trials if one.refused and not isinf(one.mass)]
    for refused, why in ((beyond, "are beyond what such joints can do"), (unbuilt, "can't be built as they are")):
        if refused:
            typer.echo(f"{len(refused)} of {len(trials)} {why}; {stem}.csv says why")


def _print_totals(arm: "SizedArm", totals: "Totals") -> tuple[float, float]:
    """Print mass and cost of an arm as built, or why it can't be built, and return them, infinite then."""
    try:
        mass, cost = totals(arm.machine)
    except DesignError as error:
        typer.echo(f"can't be built as it is: {error}", err=True)
        return inf, inf
    typer.echo(f"as built: {mass:.2f} kg" + ("" if isnan(cost) else f", cost {cost:.2f}"))
    return mass, cost


def _report_unpriced(arm: "SizedArm", prices: "Prices | None") -> None:
    """Print the parts of an arm without a price, if there are prices and the arm can be built."""
    if prices is None:
        return
    from layflat.cli.build import report_unpriced  # noqa: PLC0415  # of few runs
    from layflat.solids.cost import cost_of  # noqa: PLC0415
    from layflat.solids.totals import list_built_parts  # noqa: PLC0415

    with suppress(DesignError):
        report_unpriced(cost_of(list_built_parts(arm.machine), prices))
