"""The command that runs a machine: simulate."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import MachineName, Out, Seed, app, naming_options
from layflat.cli.bars import in_background
from layflat.cli.moves import print_missed, print_moves
from layflat.errors import DivergedError, InputError

if TYPE_CHECKING:
    import xarray

    from layflat.cli.text import Steps
    from layflat.machine import Machine
    from layflat.sim.scenario import Scenario, Signal

LEAD = 0.1
"""A move without a time begins so long after the start, s: the joints are at rest before it."""

OPTIONS = {
    "demand": "--move",
    "load": "--load",
    **{name: f"--{name}" for name in ("duration", "start", "opening", "payload", "supply", "drift", "brake", "step")},
}
"""Options by what they are called in a scenario."""


@app.command()
def simulate(
    machine: MachineName,
    move: Annotated[
        list[str] | None,
        typer.Option(help='demand: "40 deg", "40 deg, 20 deg" or "large=40 deg", with "@ 2 s" for later; repeatable'),
    ] = None,
    demand: Annotated[
        Path | None, typer.Option(metavar="FILE", help="demands over time, as `layflat excite` writes them")
    ] = None,
    opening: Annotated[str | None, typer.Option(help='open loop: valve openings, -1 to 1, such as "0.1, 0"')] = None,
    duration: Annotated[str | None, typer.Option(help="of the run  [default: 3 s, or that of the file]")] = None,
    start: Annotated[str | None, typer.Option(help="angles at the start  [default: 0 deg]")] = None,
    payload: Annotated[list[str] | None, typer.Option(help='such as "2 kg @ 1 s"; repeatable')] = None,
    supply: Annotated[list[str] | None, typer.Option(help='gauge, such as "0 bar @ 1 s"; repeatable')] = None,
    drift: Annotated[list[str] | None, typer.Option(help='of the valve\'s neutral, such as "0.2 V @ 1 s"')] = None,
    load_torque: Annotated[
        list[str] | None, typer.Option("--load", help='on the joints, such as "2 N m @ 1 s"')
    ] = None,
    brake: Annotated[list[str] | None, typer.Option(help='share of the brake\'s torque, such as "0.5 @ 1 s"')] = None,
    seed: Seed = 0,
    step: Annotated[str, typer.Option(help="of the plant")] = "0.25 ms",
    out: Out = Path("build/simulate"),
) -> None:
    """Simulate a machine with its controller.

    Prints metrics; writes NAME.nc (NetCDF) and NAME.png, after the machine's name.
    """
    from layflat.cli.text import timed  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.sim import Scenario, rollout  # noqa: PLC0415

    described = load(machine)
    _check_combination(demand, move, opening, duration)
    check_folder(out)
    names, lasts = list(described.joints), duration or "3 s"
    still: dict[str, str | float] = dict.fromkeys(names, 0.0)
    begin = timed([start] if start else [], still, "--start")[-1][1]
    moves = timed(move or [], begin, "--move")
    asked: Signal = [(0.0, begin), *[(t or LEAD, values) for t, values in moves if values != begin or t > 0.0]]
    acting = {
        "--move": moves,
        "--payload": timed(payload or [], {"payload": described.arm.payload}, "--payload"),
        "--supply": timed(supply or [], {"supply": described.supply.pressure_gauge}, "--supply"),
        "--drift": timed(drift or [], still, "--drift"),
        "--load": timed(load_torque or [], still, "--load"),
        "--brake": timed(brake or [], dict.fromkeys(names, 1.0), "--brake", bare=True),
    }
    if demand is not None:
        asked, lasts = _from_file(described, demand)
    with naming_options({**OPTIONS, "demand": f"--demand {demand}"} if demand is not None else OPTIONS):
        scenario = Scenario(
            demand=asked,
            duration=lasts,
            start=begin,
            opening=timed([opening], still, "--opening", bare=True) if opening else None,
            payload=acting["--payload"],
            supply=acting["--supply"],
            drift=acting["--drift"],
            load=acting["--load"],
            brake=acting["--brake"],
            seed=seed,
        )
        _check_times(acting, lasts)
        try:
            run = in_background(
                lambda: rollout(described, scenario=scenario, step=step),
                f"simulating {lasts} (compiles the first time)",
            )
        except DivergedError as error:
            _write_run(described, error.run, out)  # type: ignore[arg-type]
            raise
    _print_metrics(described, run, scenario, demand)
    _write_run(described, run, out)


def _check_combination(demand: Path | None, move: object, opening: object, duration: object) -> None:
    """Refuse options that would be ignored beside others.

    Raises:
        InputError: naming them.
    """
    given = {"--move": move, "--opening": opening, "--duration": duration}
    excluded = {"--demand": ["--move", "--opening", "--duration"], "--opening": ["--move"]}
    for option, beside in excluded.items():
        others = [other for other in beside if given[other]]
        if others and (demand if option == "--demand" else opening) is not None:
            raise InputError(
                f"cannot be combined with {' and '.join(others)}", where=option, right="give one or the other"
            )


def _check_times(acting: Mapping[str, Steps], lasts: str) -> None:
    """Refuse what would happen after the end of the run.

    Raises:
        InputError: naming the option.
    """
    from layflat.description import units as u  # noqa: PLC0415

    end = u.quantity(lasts, u.TIME, "--duration")
    for option, steps in acting.items():
        if steps[-1][0] >= end > 0.0:
            right = f"the run ends at {end:g} s: give an earlier time, or a longer --duration"
            raise InputError(f"{steps[-1][0]:g} s is after the end", where=option, right=right)


def _from_file(machine: Machine, demand: Path) -> tuple[Signal, str]:
    """Demands of a file, and how long they last."""
    from layflat.sim.demand_file import read_demand  # noqa: PLC0415

    if machine.controller is None:
        raise InputError("has no controller", where=machine.origin, right="give a machine that follows demands")
    rows = read_demand(machine, demand, machine.controller.cycle)
    return rows, f"{len(rows) * machine.controller.cycle!r} s"


def _print_metrics(machine: Machine, run: xarray.Dataset, scenario: Scenario, demand: Path | None) -> None:
    from layflat.sim.metrics import air_used, moves_of, peak_tip_acceleration  # noqa: PLC0415

    if demand is not None:
        print_missed(run, demand.name)
    elif scenario.opening is None:
        print_moves(moves_of(run), machine.name)
    typer.echo(
        f"air used {air_used(run):.2f} normal litres, peak tip acceleration {peak_tip_acceleration(run):.1f} m/s2"
    )


def _write_run(machine: Machine, run: xarray.Dataset, out: Path) -> None:
    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.dataset import save as save_run  # noqa: PLC0415

    typer.echo(f"wrote {save_run(run, out / f'{machine.name}.nc')}")
    typer.echo(f"wrote {save(run_figure(run), out / f'{machine.name}.png')}")
