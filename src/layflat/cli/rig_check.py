"""Command that checks whether a rig is what its description says: rig check."""

from typing import Annotated

import typer

from layflat.cli.app import MachineName, print_table
from layflat.cli.bars import busy
from layflat.cli.rig import FAULT, Address, driver_at, rigs


@rigs.command("check")
def check_rig(
    machine: MachineName,
    driver: Address,
    air: Annotated[bool, typer.Option("--air", help="bring the air and move each joint by some degrees")] = False,
) -> None:
    """Check a rig before it is used: link, timing, sensors; with --air the signs of valves and sensors too.

    Exit status 3 if a check failed.
    """
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.check.process import checked  # noqa: PLC0415

    described = load(machine)
    factory, _ = driver_at(driver, described)
    with busy("starting") as show:
        findings = checked(described, factory, air=air, tell=show)
    rows = [[one.what, one.found, one.action or "passed"] for one in findings]
    print_table(["check", "found", "action"], rows, f"{described.name} at {driver}")
    wrong = sum(not one.passed for one in findings)
    if wrong:
        typer.echo(f"{wrong} check{'s' if wrong > 1 else ''} failed")
        raise typer.Exit(FAULT)
    typer.echo("all checks passed" if air else "all checks without air passed; --air tries valves and signs")
