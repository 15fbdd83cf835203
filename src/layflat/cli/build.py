"""Command that builds a machine: solids, parts list, drawings, assembly guide, wires and air."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import bar
from layflat.cli.common import MachineName, Out, naming_options, print_table
from layflat.cli.groups import app

if TYPE_CHECKING:
    from layflat.solids.build import BuiltMachine
    from layflat.solids.cost import Cost

POSE_SHARES = {"mid": 0.0, "low": -1.0, "high": 1.0}  # names of poses, and shares of half of the working stroke


@app.register("build", "paper-small-joint", "paper-arm --pose high --out build/arm")
def build_parts(
    machine: MachineName,
    pose: Annotated[
        str, typer.Option(metavar="mid|low|high", help="mid-stroke, or an end of the working stroke")
    ] = "mid",
    prices: Annotated[
        Path | None, typer.Option(metavar="FILE", help="TOML file of prices, for a parts list with costs")
    ] = None,
    masses: Annotated[
        Path | None,
        typer.Option("--write-masses", metavar="FILE", help="description with masses and inertias from the solids"),
    ] = None,
    out: Out = Path("build/parts"),
) -> None:
    """Write all that is needed to build a machine.

    Solids (STEP, STL, glTF), parts list, drawings, assembly guide, diagrams of air and wires, firmware settings.
    """
    from layflat.errors import InputError  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.solids.build import STAGE_NAMES, build_machine  # noqa: PLC0415
    from layflat.solids.checks.masses import write_masses  # noqa: PLC0415
    from layflat.solids.cost import read_prices  # noqa: PLC0415

    if pose not in POSE_SHARES:
        raise InputError(f"unknown pose {pose!r}", where="--pose", right=f"give {', '.join(POSE_SHARES)}")
    described = load(machine)
    priced = None if prices is None else read_prices(prices)
    angles = [POSE_SHARES[pose] * joint.stops.working_stroke / 2 for joint in described.joints.values()]
    with naming_options({"out": "--out"}), bar("building", len(STAGE_NAMES)) as update:

        def show(stage: str, share: float) -> None:
            update(completed=STAGE_NAMES.index(stage) + share, description=f"building: {stage}")

        built = build_machine(described, out, angles=angles, prices=priced, aside=True, progress=show)
    _print_build(built)
    if masses is not None:
        write_masses(built.assembly, masses)
        typer.echo(f"wrote {masses}")


def _print_build(built: "BuiltMachine") -> None:
    """Print masses, costs and numbers of parts by joint, and what could not be made or has no price."""
    parts, cost = built.parts, built.cost
    made = sum(1 for part in parts.parts if not part.bought)
    rows = [[name or "arm", f"{mass:.3f}"] for name, mass in parts.masses.items()] + [["all", f"{parts.mass:.3f}"]]
    if cost is not None:
        rows = [[*row, f"{price:.2f}"] for row, price in zip(rows, (*cost.joints.values(), cost.total), strict=True)]
    print_table(["joint", "mass (kg)", *(["price"] if cost is not None else [])], rows, built.assembly.machine.name)
    found = Counter(finding.severity for finding in built.checks.findings)
    counts = ", ".join(f"{found[severity]} {severity}s" for severity in ("warning", "note"))
    typer.echo(f"checks: {counts}: {built.folder / f'{built.assembly.machine.name}-checks.html'}")
    typer.echo(f"wrote {made} kinds of parts to make and {len(parts.parts) - made} to buy to {built.folder}")
    for name, why in built.omitted.items():
        typer.echo(f"left out: {name}: {why}", err=True)
    if cost is not None:
        report_unpriced(cost)


def report_unpriced(cost: "Cost") -> None:
    """Print the parts without a price, if there are any."""
    if cost.unpriced:
        names = "; ".join(f"{part.number} {part.name}" for part in cost.unpriced)
        typer.echo(f"no price, counted as nothing: {names}", err=True)
