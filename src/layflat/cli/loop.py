"""The command that sweeps a joint: loop."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.app import MachineName, Out, app, known_joint, naming_options, print_table


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
    from layflat.plot.hysteresis import hysteresis_curves  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.sweep import sweep  # noqa: PLC0415

    described = load(machine)
    chosen = [known_joint(described, joint)] if joint else list(described.joints)
    at = u.quantity(pressure, u.PRESSURE, "--pressure")
    reach = u.quantity(stroke, u.ANGLE, "--stroke") if stroke else None
    check_folder(out)
    with naming_options({name: f"--{name}" for name in ("pressure", "stroke", "brake")}):
        swept = {name: sweep(described, name, at, stroke=reach, brake=brake) for name in chosen}
    columns = ["joint", "torque (N m)", "hysteresis height (N m)", "hysteresis (%)"]
    rows = [
        [name, f"{s.maximum_torque:.1f}", f"{s.height:.2f}", f"{100 * s.hysteresis:.1f}"] for name, s in swept.items()
    ]
    print_table(columns, rows, f"{described.name} at {pressure}")
    typer.echo(f"wrote {save(hysteresis_curves(swept), out / f'{described.name}-loop.png')}")
