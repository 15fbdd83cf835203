"""Commands that simulate a machine, or sweep a joint."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.bars import in_background
from layflat.cli.common import JointName, MachineName, Out, Seed, check_joint, expanded, naming_options, print_table
from layflat.cli.groups import app, joints
from layflat.cli.moves import parse_row, parse_steps, print_missed, print_moves, print_tip_missed, print_tip_moves
from layflat.errors import DivergedError, InputError
from layflat.motion.scenario import SIGNALS

if TYPE_CHECKING:
    import xarray

    from layflat.cli.moves import Steps
    from layflat.machine import Machine
    from layflat.motion.scenario import Scenario
    from layflat.motion.signal_rows import Signal

FIRST_MOVE_DELAY = 0.1  # of a move without a time after the start, s: the joints are stationary before it
DEFAULT_DURATION = "3 s"  # duration of a run

DISTURBANCE_SIGNALS = {name: row for name, row in SIGNALS.items() if row.option}  # signals with an option of their own
SCENARIO_OPTIONS = ("tip", "duration", "start", "opening", "step", *DISTURBANCE_SIGNALS)
"""Options that have the name of their field in a scenario."""


@dataclass(frozen=True)
class ScenarioOptions:
    """Options about the scenario of a run."""

    move: Annotated[
        list[str] | None,
        typer.Option(help='demand: "40 deg", "40 deg, 20 deg" or "large=40 deg", with "@ 2 s" for later; repeatable'),
    ] = None
    tip: Annotated[
        list[str] | None,
        typer.Option(help='demand by the place of the tip: "x=600 mm, y=0 mm, z=300 mm @ 0.5 s"; repeatable'),
    ] = None
    demand: Annotated[
        Path | None, typer.Option(metavar="FILE", help="demands over time, as `layflat excite` writes them")
    ] = None
    opening: Annotated[str | None, typer.Option(help='open loop: valve openings, -1 to 1, such as "0.1, 0"')] = None
    duration: Annotated[str | None, typer.Option(help="of the run  [default: 3 s, or that of the file]")] = None
    start: Annotated[str | None, typer.Option(help="angles at the start  [default: 0 deg]")] = None
    disturbed: dict[str, list[str] | None] = field(
        default_factory=dict,
        metadata={
            name: Annotated[list[str] | None, typer.Option(help=row.option)]
            for name, row in DISTURBANCE_SIGNALS.items()
        },
    )
    seed: Seed = 0

    def refuse_contradictions(self) -> None:
        """Raise InputError, naming them, for options that can't be combined."""
        excluding = ("demand", ("move", "tip", "opening", "duration")), ("opening", ("move", "tip")), ("tip", ("move",))
        for option, excluded in excluding:
            others = [f"--{other}" for other in excluded if getattr(self, other)]
            if others and getattr(self, option) is not None:
                what = f"cannot be combined with {' and '.join(others)}"
                raise InputError(what, where=f"--{option}", right="give one or the other")

    def scenario(self, machine: Machine) -> Scenario:
        """Return the scenario for a machine (InputError: naming the option)."""
        from layflat.motion.inverse import tip_axes  # noqa: PLC0415
        from layflat.sim import Scenario  # noqa: PLC0415

        names = list(machine.joints)
        acting: dict[str, Any] = {"duration": DEFAULT_DURATION if self.duration is None else self.duration}
        acting["start"] = parse_row(self.start, names, "--start") if self.start is not None else 0.0
        for key, row in DISTURBANCE_SIGNALS.items():
            texts, bare = self.disturbed.get(key), row.quantity is None
            if texts and row.by_joint:
                acting[key] = parse_steps(texts, names, f"--{key}", bare=bare)
            elif texts:
                steps = parse_steps(texts, [key], f"--{key}", bare=bare, of="value")
                acting[key] = [(time, values[key]) for time, values in steps]
        if self.opening is not None:
            acting |= {"opening": parse_steps([self.opening], names, "--opening", bare=True), "demand": {}}
        elif self.tip:
            acting["tip"] = _delayed_signal(parse_steps(self.tip, tip_axes(machine), "--tip", of="axis"))
        elif self.demand is not None:
            followed = _scenario_from_file(machine, self.demand)
            if twice := [key for key in DISTURBANCE_SIGNALS if key in followed and key in acting]:
                what = f"is a column of {self.demand}, too"
                raise InputError(what, where=f"--{twice[0]}", right="leave out the option or the column")
            acting |= followed if self.start is None else followed | {"start": acting["start"]}
        else:
            acting["demand"] = _delayed_signal(parse_steps(self.move or [], names, "--move"))
        return Scenario(seed=self.seed, **acting)


def _delayed_signal(steps: Steps) -> Signal:
    """Return a demand that holds the start and then follows steps; one at 0 s is delayed by `FIRST_MOVE_DELAY`."""
    moved = [(time or FIRST_MOVE_DELAY, values) for time, values in steps]
    if len(moved) > 1 and moved[1][0] <= moved[0][0]:  # a move within the time in which the joints are at rest
        moved[0] = (0.0, moved[0][1])
    return [(0.0, {}), *moved] if not moved or moved[0][0] > 0.0 else moved


@app.register(
    "simulate",
    'paper-arm --move "40 deg"',
    'paper-arm --move "small=10 deg @ 1 s" --payload "2 kg"',
    'picking-arm --tip "x=600 mm, y=0 mm, z=300 mm @ 0.5 s"',
)
@expanded
def simulate_machine(
    machine: MachineName,
    options: ScenarioOptions,
    step: Annotated[
        str, typer.Option(help="of the plant; rounded where it does not divide a control cycle")
    ] = "0.5 ms",
    out: Out = Path("build/simulate"),
) -> None:
    """Simulate a machine with its controller.

    Prints metrics; writes NAME.nc (NetCDF) and NAME.png, after the machine's name.
    """
    from layflat.cli.trimming import trim_imports  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    trim_imports()
    from layflat.sim import rollout  # noqa: PLC0415

    described = load(machine)
    options.refuse_contradictions()
    check_folder(out, f"{described.name}.nc", f"{described.name}.png")
    demand = "--move" if options.demand is None else f"--demand {options.demand}"
    with naming_options({"demand": demand, **{name: f"--{name}" for name in SCENARIO_OPTIONS}}):
        scenario = options.scenario(described)
        what = f"simulating {scenario.duration} (compiles the first time)"
        try:
            done = [0.0]
            run = in_background(
                lambda: rollout(described, scenario=scenario, step=step, progress=done.append), what, lambda: done[-1]
            )
        except DivergedError as error:
            _write_run(described, error.run, out)  # type: ignore[arg-type]
            raise
    _print_rounded_step(run, step)
    _print_metrics(described, run, scenario, options.demand)
    _write_run(described, run, out)


def _print_rounded_step(run: xarray.Dataset, requested: str) -> None:
    """Print the plant's step if the requested one was rounded, since it does not divide a control cycle."""
    from math import isclose  # noqa: PLC0415

    from layflat.description import units as u  # noqa: PLC0415

    used = float(run.attrs["step"])
    if not isclose(used, u.quantity(requested, u.TIME, "--step"), rel_tol=1e-6):
        typer.echo(f"steps of {1e3 * used:.4g} ms: {requested} does not divide a control cycle")


def _scenario_from_file(machine: Machine, demand: Path) -> dict[str, Any]:
    """Return the scenario's fields from a file of demands: it begins at the first row and ends with the last.

    They are the demand with its velocities and accelerations, disturbances by name, `start` (None) and `duration`.

    Raise InputError if the machine has no controller, or the file is no file of demands.
    """
    from layflat.motion.demand_file import read_acting  # noqa: PLC0415

    if machine.controller is None:
        raise InputError("has no controller", where=machine.origin, right="give a machine that follows demands")
    demands, disturbances = read_acting(machine, demand, machine.controller.cycle)
    rates = {"demand_velocity": demands.velocities, "demand_acceleration": demands.accelerations}
    fields = {"demand": demands.angles, **rates, **disturbances}
    return fields | {"start": None, "duration": f"{len(demands.angles) * machine.controller.cycle!r} s"}


def _print_metrics(machine: Machine, run: xarray.Dataset, scenario: Scenario, demand: Path | None) -> None:
    """Print the moves of a run (none in open loop) or its deviations from a demand file, air, and peak acceleration.

    A controller that gave up is reported, too.
    """
    from layflat.sim.metrics import air_used, measure_moves, peak_tip_acceleration  # noqa: PLC0415

    if demand is not None:
        print_missed(run, demand.name)
        print_tip_missed(run)
    elif scenario.opening is None:
        print_moves(measure_moves(run), machine.name)
        print_tip_moves(run, machine.name)
    gives_up = machine.control_law.gives_up if machine.controller is not None else None
    if gives_up is not None and run[gives_up].any():
        since = float(run["time"][run[gives_up].any("joint").argmax()])
        typer.echo(f"the controller gave up at {since:.2f} s: its model is too far from the plant (docs/control.md)")
    acceleration = peak_tip_acceleration(run)
    typer.echo(f"air used {air_used(run):.2f} normal litres, peak tip acceleration {acceleration:.1f} m/s2")


def _write_run(machine: Machine, run: xarray.Dataset, out: Path) -> None:
    """Write data set and figure of a run to a folder, and print their paths."""
    from layflat.cli.trimming import hide_packages, without_space  # noqa: PLC0415

    with without_space():
        from layflat.plot.runs import run_figure  # noqa: PLC0415
        from layflat.plot.style import save_figure  # noqa: PLC0415
    from layflat.sim.dataset import save_run  # noqa: PLC0415

    with hide_packages("dask"):
        path = save_run(run, out / f"{machine.name}.nc")
    typer.echo(f"wrote {path}")
    typer.echo(f"wrote {save_figure(run_figure(run), out / f'{machine.name}.png')}")


@joints.register("sweep", 'paper-arm --joint small --pressure "3 bar"')
def sweep_joints(
    machine: MachineName,
    joint: JointName = None,
    pressure: Annotated[str, typer.Option(help="gauge pressure in hose A")] = "3 bar",
    stroke: Annotated[str | None, typer.Option(help="of the sweep, end to end  [default: the working stroke]")] = None,
    brake: Annotated[float, typer.Option(help="share of the brake's torque")] = 1.0,
    out: Out = Path("build/loop"),
) -> None:
    """Sweep a joint at constant pressure: its hysteresis curve.

    Writes NAME-loop.png, after the machine's name.
    """
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.plot.curves import hysteresis_curves  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415
    from layflat.sim.sweep import sweep  # noqa: PLC0415

    described = load(machine)
    chosen = [check_joint(described, joint)] if joint else list(described.joints)
    at = u.quantity(pressure, u.PRESSURE, "--pressure")
    reach = u.quantity(stroke, u.ANGLE, "--stroke") if stroke else None
    check_folder(out, f"{described.name}-loop.png")
    with naming_options({name: f"--{name}" for name in ("pressure", "stroke", "brake")}):
        swept = {name: sweep(described, name, at, stroke=reach, brake=brake) for name in chosen}
    columns = ["joint", "torque (N m)", "hysteresis height (N m)", "hysteresis (%)"]
    rows = [
        [name, f"{s.maximum_torque:.1f}", f"{s.height:.2f}", f"{100 * s.hysteresis:.1f}"] for name, s in swept.items()
    ]
    print_table(columns, rows, f"{described.name} at {pressure}")
    typer.echo(f"wrote {save_figure(hysteresis_curves(swept), out / f'{described.name}-loop.png')}")
