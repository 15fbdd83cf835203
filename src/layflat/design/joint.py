"""The design of one joint from its description, checked by the design rules."""

from dataclasses import replace
from pathlib import Path

from layflat.description.wrong import shown
from layflat.design import straplines
from layflat.design.cam import synthesise
from layflat.design.characteristic import Characteristic, Through, of_cylinder, spline
from layflat.design.findings import refuse_errors
from layflat.design.outline import cam_outline
from layflat.design.rules import check
from layflat.design.summary import JointDesign
from layflat.errors import DesignError, MachineError
from layflat.machine import Machine, load


def design_joint(
    machine: str | Path | Machine, joint: str | None = None, *, measured: Characteristic | None = None,
    bore: float | None = None, strict: bool = True, through: Through = spline,
) -> JointDesign:  # fmt: skip
    """Design one joint of a machine.

    The cam keeps stroke and mean torque of the round roller of output.radius, as the machine's parameters do.

    Args:
        machine: a machine, its built-in name, or its file.
        joint: the joint's name; not needed where there is one only.
        measured: a measured curve in place of Eq. (1), from `read_characteristic`.
        bore: diameter of the cam's bore, m.
        strict: raise the first error that the rules find; otherwise it stands among the findings only.
        through: lays a curve through what Eq. (1) gives; `stencils` finds the same without SciPy.

    Raises:
        MachineError: there is no such machine or joint.
        DesignError: it can't be made, in one line that says why.
    """
    machine = load(machine)
    names = list(machine.joints)
    if joint is None and len(names) > 1:
        raise MachineError("the joint is missing", where=machine.origin, right=f"name one of {', '.join(names)}")
    name = names[0] if joint is None else joint
    if not isinstance(name, str) or name not in machine.joint:
        raise MachineError(
            f"unknown joint {shown(name)}", where=machine.origin, right=f"name one of {', '.join(names)}"
        )
    described = machine.joint[name]
    characteristic = measured or of_cylinder(described, through=through)
    cam = outline = None
    if described.output.kind == "cam":
        try:
            stroke = characteristic.full_travel / described.output.radius
            cam = synthesise(characteristic, straplines.of_joint(described), stroke)
            outline = cam_outline(cam, bore) if cam.convex else None
        except DesignError as error:
            where = f"{machine.origin}: joint.{name}.output"
            raise DesignError(error.what, where=where, right=error.right) from None
    design = JointDesign(machine, name, machine.supply.pressure_gauge, characteristic, cam, outline)
    found = check(design)
    if strict:
        refuse_errors(found)
    return replace(design, findings=found)
