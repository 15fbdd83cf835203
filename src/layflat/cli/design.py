"""Commands that design joints: design, size."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import MachineName, Out, app, known_joint, print_findings, print_table

if TYPE_CHECKING:
    from layflat.design import Characteristic


@app.command()
def design(
    machine: MachineName,
    joint: Annotated[str | None, typer.Option(help="joint; all joints where not given")] = None,
    table: Annotated[Path | None, typer.Option(metavar="CSV", help="measured torque over angle, for Eq. (1)")] = None,
    pressure: Annotated[str | None, typer.Option(help="gauge pressure of the measurement")] = None,
    out: Out = Path("build/design"),
) -> None:
    """Design a machine's joints: torque, cam, strap, mass, air; write the cam as DXF, SVG and CSV."""
    from layflat.cli.design_tables import print_design  # noqa: PLC0415
    from layflat.design import design_joint, write_drawings  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    described = load(machine)
    chosen = [known_joint(described, joint)] if joint else list(described.joints)
    designs = []
    for name in chosen:
        measured = _measured(table, pressure, described.joint[name].output.radius) if table else None
        designs.append(design_joint(described, name, measured=measured))
    check_folder(out)
    for made in designs:
        print_design(made, print_table)
        print_findings(made.findings)
        for path in write_drawings(made, out) if made.cam is not None else []:
            typer.echo(f"wrote {path}")


@app.command()
def size(
    torque: Annotated[str, typer.Option(help='over the whole working stroke, such as "25 N m"')],
    stroke: Annotated[str, typer.Option(help='working stroke, such as "120 deg"')],
    supply: Annotated[str, typer.Option(help='gauge pressure of the supply, such as "4 bar"')],
    wrap: Annotated[str | None, typer.Option(help="wrap angle of the collapsed hose")] = None,
    hose_width: Annotated[str | None, typer.Option(help="of the flat hose; a standard width where not given")] = None,
    cylinder_diameter: Annotated[str | None, typer.Option(help="of the outer cylinder")] = None,
    strap_width: Annotated[str | None, typer.Option(help="of the steel strap")] = None,
    strap_thickness: Annotated[str | None, typer.Option(help="of the steel strap")] = None,
    payload_inertia: Annotated[str | None, typer.Option(help="about the joint")] = None,
    name: Annotated[str, typer.Option(help="of the machine")] = "sized-joint",
    out: Out = Path("build/size"),
) -> None:
    """Size a joint from what it shall do: a complete description that can be simulated, and its drawings."""
    from layflat.cli.design_tables import print_design  # noqa: PLC0415
    from layflat.design import SizingRequest, size_joint, write_drawings  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    request = SizingRequest.from_text(
        torque=torque,
        stroke=stroke,
        supply=supply,
        wrap=wrap,
        hose_width=hose_width,
        cylinder_diameter=cylinder_diameter,
        strap_width=strap_width,
        strap_thickness=strap_thickness,
        payload_inertia=payload_inertia,
        name=name,
    )
    sized = size_joint(request)
    check_folder(out)
    print_design(sized.design, print_table)
    print_findings(sized.findings)
    typer.echo(f"wrote {sized.write(out / f'{name}.toml')}")
    for path in write_drawings(sized.design, out):
        typer.echo(f"wrote {path}")


def _measured(table: Path, pressure: str | None, radius: float) -> Characteristic:
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.design import read_characteristic  # noqa: PLC0415

    at = u.quantity(pressure, u.PRESSURE, "--pressure") if pressure else None
    return read_characteristic(table, pressure=at, roller_radius=radius)
