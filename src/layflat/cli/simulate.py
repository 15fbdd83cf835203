"""The command that runs a machine: simulate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.app import MachineName, Out, app
from layflat.cli.moves import print_missed, print_moves
from layflat.errors import DivergedError, InputError

if TYPE_CHECKING:
    import xarray

    from layflat.machine import Machine
    from layflat.sim.scenario import Scenario, Signal


LEAD = 0.1
"""A move without a time begins so long after the start, s: the joints are at rest before it."""


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
    opening: Annotated[str | None, typer.Option(help='open loop: valve openings, such as "0.1, 0"')] = None,
    duration: Annotated[str | None, typer.Option(help="of the run; 3 s, or that of the file, where not given")] = None,
    start: Annotated[str | None, typer.Option(help="angles at the start; zero where not given")] = None,
    payload: Annotated[list[str] | None, typer.Option(help='such as "2 kg @ 1 s"; repeatable')] = None,
    supply: Annotated[list[str] | None, typer.Option(help='gauge, such as "0 bar @ 1 s"; repeatable')] = None,
    drift: Annotated[list[str] | None, typer.Option(help='of the valve\'s neutral, such as "0.2 V @ 1 s"')] = None,
    load_torque: Annotated[
        list[str] | None, typer.Option("--load", help='on the joints, such as "2 N m @ 1 s"')
    ] = None,
    brake: Annotated[list[str] | None, typer.Option(help='share of the brake\'s torque, such as "0.5 @ 1 s"')] = None,
    seed: Annotated[int, typer.Option(help="of the sensors' noise")] = 0,
    step: Annotated[str, typer.Option(help="of the plant")] = "0.25 ms",
    out: Out = Path("build/simulate"),
) -> None:
    """Simulate a machine with its controller: metrics, a NetCDF data set and a figure."""
    from layflat.cli.text import timed  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.sim import Scenario, rollout  # noqa: PLC0415

    described = load(machine)
    names = list(described.joints)
    check_folder(out)
    still: dict[str, str | float] = dict.fromkeys(names, 0.0)
    begin = timed([start] if start else [], still, "--start")[-1][1]
    moves = timed(move or [], begin, "--move")
    asked: Signal = [(0.0, begin), *[(t or LEAD, values) for t, values in moves if values != begin or t > 0.0]]
    if demand is not None:
        asked, duration = _from_file(described, demand, moves[1:], duration)
    scenario = Scenario(
        demand=asked,
        duration=duration or "3 s",
        start=begin,
        opening=timed([opening], still, "--opening", bare=True) if opening else None,
        payload=timed(payload or [], {"payload": described.arm.payload}, "--payload"),
        supply=timed(supply or [], {"supply": described.supply.pressure_gauge}, "--supply"),
        drift=timed(drift or [], still, "--drift"),
        load=timed(load_torque or [], still, "--load"),
        brake=timed(brake or [], dict.fromkeys(names, 1.0), "--brake", bare=True),
        seed=seed,
    )
    try:
        run = _waiting("simulating", lambda: rollout(described, scenario=scenario, step=step))
    except DivergedError as error:
        _write_run(described, error.run, out)  # type: ignore[arg-type]
        raise
    _print_metrics(described, run, scenario, demand)
    _write_run(described, run, out)


def _from_file(machine: Machine, demand: Path, moves: Sequence[object], duration: str | None) -> tuple[Signal, str]:
    """Demands of a file, and how long they last."""
    from layflat.sim.demand_file import read_demand  # noqa: PLC0415

    if moves or duration:
        right = "leave --move and --duration out"
        raise InputError("says it all", where=f"--demand {demand}", right=right)
    if machine.controller is None:
        raise InputError("has no controller", where=machine.origin, right="give a machine that follows demands")
    rows = read_demand(machine, demand, machine.controller.cycle)
    return rows, f"{len(rows) * machine.controller.cycle!r} s"


def _waiting(what: str, work: Callable[[], Any]) -> Any:
    """Show that something is going on, on a terminal."""
    from rich.console import Console  # noqa: PLC0415

    with Console(stderr=True).status(f"{what} (compiles for some seconds the first time)"):
        return work()


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
