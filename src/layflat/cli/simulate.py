"""Commands that simulate a machine (simulate) or sweep a joint (loop)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.app import MachineName, Out, Seed, app, expanded, known_joint, naming_options, print_table
from layflat.cli.bars import in_background
from layflat.cli.moves import parse_row, parse_steps, print_missed, print_moves, print_tip_missed, print_tip_moves
from layflat.errors import DivergedError, InputError
from layflat.motion.scenario import SIGNALS

if TYPE_CHECKING:
    import xarray

    from layflat.cli.moves import Steps
    from layflat.machine import Machine
    from layflat.motion.scenario import Scenario
    from layflat.motion.signal_rows import Signal

LEAD = 0.1  # a move without a time begins so long after the start, s: the joints are at rest before it
USUAL_DURATION = "3 s"  # duration of a run

DISTURBED = {name: row for name, row in SIGNALS.items() if row.option}  # by options of their own
SAME_IN_SCENARIO = ("tip", "duration", "start", "opening", "step", *DISTURBED)
"""Options that are called the same in a scenario."""


@dataclass(frozen=True)
class Asked:
    """Options that say what happens in a run."""

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
        metadata={name: Annotated[list[str] | None, typer.Option(help=row.option)] for name, row in DISTURBED.items()},
    )
    seed: Seed = 0

    def refuse_contradictions(self) -> None:
        """Refuse options that would be ignored beside others (InputError: naming them)."""
        excluding = ("demand", ("move", "tip", "opening", "duration")), ("opening", ("move", "tip")), ("tip", ("move",))
        for option, excluded in excluding:
            others = [f"--{other}" for other in excluded if getattr(self, other)]
            if others and getattr(self, option) is not None:
                what = f"cannot be combined with {' and '.join(others)}"
                raise InputError(what, where=f"--{option}", right="give one or the other")

    def scenario(self, machine: Machine) -> Scenario:
        """Return all that happens to a machine (InputError: naming the option)."""
        from layflat.motion.tip_demand import axes_of  # noqa: PLC0415
        from layflat.sim import Scenario  # noqa: PLC0415

        names = list(machine.joints)
        acting: dict[str, Any] = {"duration": USUAL_DURATION if self.duration is None else self.duration}
        acting["start"] = parse_row(self.start, names, "--start") if self.start is not None else 0.0
        for key, row in DISTURBED.items():
            texts, bare = self.disturbed.get(key), row.quantity is None
            if texts and row.by_joint:
                acting[key] = parse_steps(texts, names, f"--{key}", bare=bare)
            elif texts:
                steps = parse_steps(texts, [key], f"--{key}", bare=bare, of="value")
                acting[key] = [(time, values[key]) for time, values in steps]
        if self.opening is not None:
            acting |= {"opening": parse_steps([self.opening], names, "--opening", bare=True), "demand": {}}
        elif self.tip:
            acting["tip"] = _signal(parse_steps(self.tip, axes_of(machine), "--tip", of="axis"))
        elif self.demand is not None:
            followed = _from_file(machine, self.demand)
            if twice := [key for key in DISTURBED if key in followed and key in acting]:
                what = f"stands beside the columns of {self.demand}"
                raise InputError(what, where=f"--{twice[0]}", right="give one or the other")
            acting |= followed if self.start is None else followed | {"start": acting["start"]}
        else:
            acting["demand"] = _signal(parse_steps(self.move or [], names, "--move"))
        return Scenario(seed=self.seed, **acting)


def _signal(steps: Steps) -> Signal:
    """Return a demand that begins with the start and goes on as steps do, the first of them a little later."""
    moved = [(time or LEAD, values) for time, values in steps]
    if len(moved) > 1 and moved[1][0] <= moved[0][0]:  # a move within the time in which the joints are at rest
        moved[0] = (0.0, moved[0][1])
    return [(0.0, {}), *moved] if not moved or moved[0][0] > 0.0 else moved


@app.command()
@expanded
def simulate(
    machine: MachineName,
    asked: Asked,
    step: Annotated[
        str, typer.Option(help="of the plant; rounded where it does not divide a control cycle")
    ] = "0.5 ms",
    out: Out = Path("build/simulate"),
) -> None:
    """Simulate a machine with its controller.

    Prints metrics; writes NAME.nc (NetCDF) and NAME.png, after the machine's name.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.sim import rollout  # noqa: PLC0415

    described = load(machine)
    asked.refuse_contradictions()
    check_folder(out, f"{described.name}.nc", f"{described.name}.png")
    demand = "--move" if asked.demand is None else f"--demand {asked.demand}"
    with naming_options({"demand": demand, **{name: f"--{name}" for name in SAME_IN_SCENARIO}}):
        scenario = asked.scenario(described)
        what = f"simulating {scenario.duration} (compiles the first time)"
        try:
            done = [0.0]
            run = in_background(
                lambda: rollout(described, scenario=scenario, step=step, progress=done.append), what, lambda: done[-1]
            )
        except DivergedError as error:
            _write_run(described, error.run, out)  # type: ignore[arg-type]
            raise
    _print_rounded(run, step)
    _print_metrics(described, run, scenario, asked.demand)
    _write_run(described, run, out)


def _print_rounded(run: xarray.Dataset, asked: str) -> None:
    """Say which step was taken where the one that was asked for does not divide a control cycle."""
    from math import isclose  # noqa: PLC0415

    from layflat.description import units as u  # noqa: PLC0415

    taken = float(run.attrs["step"])
    if not isclose(taken, u.quantity(asked, u.TIME, "--step"), rel_tol=1e-6):
        typer.echo(f"steps of {1e3 * taken:.4g} ms: {asked} does not divide a control cycle")


def _from_file(machine: Machine, demand: Path) -> dict[str, Any]:
    """Return what a file of demands says of a scenario, which begins at their first row and lasts as long as they."""
    from layflat.motion.demand_file import read_acting  # noqa: PLC0415

    if machine.controller is None:
        raise InputError("has no controller", where=machine.origin, right="give a machine that follows demands")
    asked, disturbances = read_acting(machine, demand, machine.controller.cycle)
    rates = {"demand_velocity": asked.velocities, "demand_acceleration": asked.accelerations}
    found = {"demand": asked.angles, **rates, **disturbances}
    return found | {"start": None, "duration": f"{len(asked.angles) * machine.controller.cycle!r} s"}


def _print_metrics(machine: Machine, run: xarray.Dataset, scenario: Scenario, demand: Path | None) -> None:
    from layflat.sim.metrics import air_used, moves_of, peak_tip_acceleration  # noqa: PLC0415

    if demand is not None:
        print_missed(run, demand.name)
        print_tip_missed(run)
    elif scenario.opening is None:
        print_moves(moves_of(run), machine.name)
        print_tip_moves(run, machine.name)
    gives_up = machine.control_law.gives_up if machine.controller is not None else None
    if gives_up is not None and run[gives_up].any():
        since = float(run["time"][run[gives_up].any("joint").argmax()])
        typer.echo(f"the controller gave up at {since:.2f} s: its model is too far from the plant (docs/control.md)")
    acceleration = peak_tip_acceleration(run)
    typer.echo(f"air used {air_used(run):.2f} normal litres, peak tip acceleration {acceleration:.1f} m/s2")


def _write_run(machine: Machine, run: xarray.Dataset, out: Path) -> None:
    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.dataset import save as save_run  # noqa: PLC0415

    typer.echo(f"wrote {save_run(run, out / f'{machine.name}.nc')}")
    typer.echo(f"wrote {save(run_figure(run), out / f'{machine.name}.png')}")


@app.command()
def loop(
    machine: MachineName,
    joint: Annotated[str | None, typer.Option(help="[default: all joints]")] = None,
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
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.sweep import sweep  # noqa: PLC0415

    described = load(machine)
    chosen = [known_joint(described, joint)] if joint else list(described.joints)
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
    typer.echo(f"wrote {save(hysteresis_curves(swept), out / f'{described.name}-loop.png')}")
