"""Commands that size and design joints."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat import extras
from layflat.cli.common import (
    JointName,
    MachineName,
    Out,
    check_joint,
    expanded,
    naming_options,
    print_findings,
    print_table,
)
from layflat.cli.groups import joints
from layflat.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from layflat.design import Characteristic, JointDesign
    from layflat.machine import Machine


CAM_TABLE_ROWS = 11  # rows of the cam's table, as the paper's Table 1 has


@joints.register("design", "paper-arm", 'paper-arm --joint small --table m.csv --pressure "3 bar"')
def design_joints(
    machine: MachineName,
    joint: JointName = None,
    table: Annotated[Path | None, typer.Option(metavar="CSV", help="measured torque over angle, for Eq. (1)")] = None,
    pressure: Annotated[str | None, typer.Option(help="gauge pressure at which --table was measured")] = None,
    out: Out = Path("build/design"),
) -> None:
    """Design a machine's joints: torque, cam, strap, mass, air.

    Writes the cam as DXF, SVG and CSV, and the layout as SVG. DXF needs the extra `drawing`.
    """
    from layflat.design import design_joint  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    described = load(machine)
    chosen = [check_joint(described, joint)] if joint is not None else list(described.joints)
    measured = _read_measured(described, chosen, table, pressure)
    designs = [design_joint(described, name, measured=measured) for name in chosen]
    check_folder(out)
    if any(joint_design.cam is not None for joint_design in designs):
        report_missing_dxf()
    for joint_design in designs:
        _print_design(joint_design)
    for joint_design in designs:
        _write_drawings(joint_design, out)


@dataclass(frozen=True)
class SizingOptions:
    """Options about the requirements of a joint: the arguments of `SizingRequest`."""

    torque: Annotated[str, typer.Option(help='over the whole working stroke, such as "25 N m"')]
    stroke: Annotated[str, typer.Option(help='working stroke, such as "120 deg"')]
    supply: Annotated[str, typer.Option(help='gauge pressure of the supply, such as "4 bar"')]
    wrap: Annotated[str | None, typer.Option(help="wrap angle of the collapsed hose; default: 120 deg")] = None
    hose_width: Annotated[str | None, typer.Option(help="of the flat hose; default: a standard width")] = None
    cylinder_diameter: Annotated[str | None, typer.Option(help="of the outer cylinder; default: chosen")] = None
    strap_width: Annotated[str | None, typer.Option(help="of the steel strap; default: chosen")] = None
    strap_thickness: Annotated[str | None, typer.Option(help="of the steel strap; default: chosen")] = None
    link_length: Annotated[str | None, typer.Option(help="from the joint to the payload; default: 400 mm")] = None
    payload_inertia: Annotated[
        str | None, typer.Option(help="about the joint; default: 0.01 kg m^2 per N m of torque")
    ] = None
    name: Annotated[str, typer.Option(help="of the machine and its file")] = "sized-joint"


@joints.register("size", '--torque "25 N m" --stroke "120 deg" --supply "4 bar"')
@expanded
def size_from_requirements(options: SizingOptions, out: Out = Path("build/size")) -> None:
    """Size a joint from the torque and stroke it must have.

    Writes a complete description that can be simulated, and its drawings.
    """
    from layflat.design import SizingRequest, size_joint  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    given = {key: value for key, value in asdict(options).items() if value is not None}
    with naming_options({f"size: {name}": f"--{name.replace('_', '-')}" for name in given}):
        request = SizingRequest(**given)
    check_folder(out, f"{options.name}.toml")
    sized = size_joint(request)
    report_missing_dxf()
    _print_design(sized.design)
    path = sized.write(out / f"{options.name}.toml")
    typer.echo(f"wrote {path}")
    _write_drawings(sized.design, out)
    typer.echo(f"the controller's gains are the paper's, scaled; to tune them for this joint: layflat tune {path}")


def report_missing_dxf() -> None:
    """Print to stderr, before any work is done, which extra DXF needs, if it is not installed; the work goes on."""
    try:
        extras.require("drawing", where="no DXF")
    except MissingExtraError as missing:
        typer.echo(f"layflat: {missing}", err=True)


def _print_design(design: "JointDesign") -> None:
    """Print quantities of a joint, the cam's table, the strap's stresses, and the findings of the design rules."""
    import numpy as np  # noqa: PLC0415

    print_table(["quantity", "value"], design.quantity_rows(), f"{design.machine.name}, {design.name} joint")
    if design.cam is not None:
        columns = design.columns()
        shown = ["travel_mm", "force_N", "tension_N", "lever_mm", "cam_angle_deg", "torque_Nm", "curvature_radius_mm"]
        indices = np.linspace(0, len(columns["travel_mm"]) - 1, CAM_TABLE_ROWS).round().astype(int)
        print_table(shown, [[f"{columns[name][i]:.2f}" for name in shown] for i in indices], "cam")
    rows = [
        [s.location, *(f"{value / 1e6:.0f}" for value in (s.tensile, s.bending, s.yield_stress)), f"{s.safety:.2f}"]
        for s in design.stresses
    ]
    print_table(["strap over", "tension (MPa)", "bending (MPa)", "yield (MPa)", "safety"], rows, "strap")
    print_findings(design.findings)


def _write_drawings(design: "JointDesign", out: Path) -> None:
    """Write the drawings of a joint that has a cam, and print their paths."""
    from layflat.design import write_drawings  # noqa: PLC0415

    for path in write_drawings(design, out) if design.cam is not None else []:
        typer.echo(f"wrote {path}")


def _read_measured(
    machine: "Machine", chosen: list[str], table: Path | None, pressure: str | None
) -> "Characteristic | None":
    """Return the characteristic in --table, measured on one joint at --pressure; None without --table.

    Raise InputError for --pressure alone, or a table of several joints.
    """
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.design import read_characteristic  # noqa: PLC0415

    if table is None:
        if pressure is not None:
            raise InputError("needs --table", where="--pressure", right="add the measured table, or leave it out")
        return None
    if len(chosen) > 1:
        raise InputError("measures one joint", where="--table", right=f"add --joint {' or --joint '.join(chosen)}")
    measured_pressure = u.quantity(pressure, u.PRESSURE, "--pressure") if pressure is not None else None
    return read_characteristic(table, pressure=measured_pressure, roller_radius=machine.joint[chosen[0]].output.radius)
