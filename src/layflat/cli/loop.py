"""The command that sweeps a joint: loop."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.app import MachineName, Out, app, known_joint, print_table
from layflat.errors import InputError


@app.command()
def loop(
    machine: MachineName,
    joint: Annotated[str | None, typer.Option(help="joint; all joints where not given")] = None,
    pressure: Annotated[str, typer.Option(help="gauge pressure in hose A")] = "3 bar",
    stroke: Annotated[str | None, typer.Option(help="of the sweep; the working stroke where not given")] = None,
    brake: Annotated[float, typer.Option(help="share of the brake's torque")] = 1.0,
    out: Out = Path("build/loop"),
) -> None:
    """Sweep a joint slowly at constant pressure: its torque-angle loop."""
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.plot.loops import loops  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.sweep import sweep  # noqa: PLC0415

    described = load(machine)
    chosen = [known_joint(described, joint)] if joint else list(described.joints)
    at = u.quantity(pressure, u.PRESSURE, "--pressure")
    if at <= 0.0:
        raise InputError(
            f"{pressure!r} presses no hose", where="--pressure", right='give a gauge pressure such as "3 bar"'
        )
    reach = u.quantity(stroke, u.ANGLE, "--stroke") if stroke else None
    swept = {name: sweep(described, name, at, stroke=reach, brake=brake) for name in chosen}
    rows = [
        [name, f"{s.maximum_torque:.1f}", f"{s.height:.2f}", f"{100 * s.hysteresis:.1f}"] for name, s in swept.items()
    ]
    print_table(
        ["joint", "torque (N m)", "loop height (N m)", "hysteresis (%)"], rows, f"{described.name} at {pressure}"
    )
    typer.echo(f"wrote {save(loops(swept), out / f'{described.name}-loop.png')}")
