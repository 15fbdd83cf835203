"""Commands that design joints: design, size."""

from dataclasses import asdict, dataclass
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat import extras
from layflat.cli.app import MachineName, Out, app, expanded, known_joint, print_findings, print_table
from layflat.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from layflat.design import Characteristic, JointDesign
    from layflat.machine import Machine


ROWS = 11  # rows of the cam's table, as the paper's Table 1 has


@app.command()
def design(
    machine: MachineName,
    joint: Annotated[str | None, typer.Option(help="default: all joints")] = None,
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
    chosen = [known_joint(described, joint)] if joint is not None else list(described.joints)
    measured = _measured(described, chosen, table, pressure)
    designs = [design_joint(described, name, measured=measured) for name in chosen]
    check_folder(out)
    if any(made.cam is not None for made in designs):
        say_what_is_left_out()
    for made in designs:
        _print(made)
    for made in designs:
        _draw(made, out)


@dataclass(frozen=True)
class Wanted:
    """Options that say what a joint is sized for, as `SizingRequest.from_text` takes them."""

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


@app.command()
@expanded
def size(wanted: Wanted, out: Out = Path("build/size")) -> None:
    """Size a joint from the torque and stroke it must have.

    Writes a complete description that can be simulated, and its drawings.
    """
    from layflat.design import SizingRequest, size_joint  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    request = SizingRequest.from_text(**asdict(wanted))
    check_folder(out, f"{wanted.name}.toml")
    sized = size_joint(request)
    say_what_is_left_out()
    _print(sized.design)
    path = sized.write(out / f"{wanted.name}.toml")
    typer.echo(f"wrote {path}")
    _draw(sized.design, out)
    typer.echo(f"the controller's gains are the paper's, scaled; to tune them for this joint: layflat tune {path}")


def say_what_is_left_out() -> None:
    """Say in one line, before any work is done, which extra brings the DXF where it is not installed."""
    try:
        extras.require("drawing", where="no DXF")
    except MissingExtraError as missing:
        typer.echo(f"layflat: {missing}", err=True)


def _print(design: "JointDesign") -> None:
    """Print what was designed, the cam's columns, the strap's stresses, and what the rules found."""
    import numpy as np  # noqa: PLC0415

    from layflat.design.strength import shaft_advice  # noqa: PLC0415

    joint, (angle, torque) = design.joint, design.torque
    rows = [
        ["torque", f"{torque.min():.1f} to {torque.max():.1f} N m at {design.pressure / 1e5:g} bar gauge"],
        ["full travel", f"{degrees(angle[-1]):.1f} deg (working stroke {degrees(joint.stops.working_stroke):.0f} deg)"],
        ["hose", f"{1e3 * joint.hose.width:.0f} mm wide, wrapped {degrees(joint.hose.wrap):.0f} deg"],
        ["cylinder", f"{1e3 * joint.cylinder.diameter:.1f} mm in diameter"],
        ["output", f"{joint.output.kind}, {1e3 * joint.output.radius:.2f} mm mean radius"],
        ["mass", f"{design.mass.body:.2f} kg, of which {design.mass.counted:.2f} kg hose, cylinder, shell, strap, cam"],
        ["air per stroke", f"{design.air.normal_litres:.2f} normal litres"],
    ]
    if design.outline is not None:
        rows.append(["shaft", shaft_advice(float(torque.max()), design.outline.bore)])
    print_table(["quantity", "value"], rows, f"{design.machine.name}, {design.name} joint")
    if design.cam is not None:
        columns = design.columns()
        shown = ["travel_mm", "force_N", "tension_N", "lever_mm", "cam_angle_deg", "torque_Nm", "curvature_radius_mm"]
        at = np.linspace(0, len(columns["travel_mm"]) - 1, ROWS).round().astype(int)
        print_table(shown, [[f"{columns[name][i]:.2f}" for name in shown] for i in at], "cam")
    rows = [
        [s.place, *(f"{value / 1e6:.0f}" for value in (s.tensile, s.bending, s.yield_stress)), f"{s.safety:.2f}"]
        for s in design.stresses
    ]
    print_table(["strap over", "tension (MPa)", "bending (MPa)", "yield (MPa)", "safety"], rows, "strap")
    print_findings(design.findings)


def _draw(made: "JointDesign", out: Path) -> None:
    from layflat.design import write_drawings  # noqa: PLC0415

    for path in write_drawings(made, out) if made.cam is not None else []:
        typer.echo(f"wrote {path}")


def _measured(
    machine: "Machine", chosen: list[str], table: Path | None, pressure: str | None
) -> "Characteristic | None":
    """Read --table, which measures one joint, at --pressure."""
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.design import read_characteristic  # noqa: PLC0415

    if table is None:
        if pressure is not None:
            raise InputError("needs --table", where="--pressure", right="it is the pressure of a measured table")
        return None
    if len(chosen) > 1:
        raise InputError("measures one joint", where="--table", right=f"add --joint {' or --joint '.join(chosen)}")
    at = u.quantity(pressure, u.PRESSURE, "--pressure") if pressure is not None else None
    return read_characteristic(table, pressure=at, roller_radius=machine.joint[chosen[0]].output.radius)
