"""Description of how a joint is built: sizes that the laws do not need, each with a rule as its default."""

from typing import Annotated

from pydantic import Field

from layflat.description import Part
from layflat.description import units as u


class Build(Part):
    """Sizes of a joint's parts that its laws do not need; what is left out follows from a rule."""

    clearance: u.Clearance = Field(default=0.002, description="least distance between parts that move past each other")
    hose_wall: u.Thickness | None = Field(
        default=None, description="thickness of one layer of hose; default: areal_mass over 1150 kg/m^3, of rubber"
    )
    shaft_diameter: u.Size | None = Field(
        default=None, description="default: smallest common bore that bears the straps' pull beside the bearings"
    )
    end_plate_thickness: u.Thickness | None = Field(
        default=None, description="default: sold thickness as wide as the bearing, at least 6 % of the diameter"
    )
    arm_plate_thickness: u.Thickness | None = Field(
        default=None, description="default: thinnest sold one that bears the joint's torque"
    )
    clamp_bar_thickness: u.Thickness | None = Field(
        default=None, description="of the bars that clamp the hoses; default: thinnest sold one, at 2 screws a bar"
    )
    screw: Annotated[str, Field(pattern=r"^M\d+(\.\d)?$")] | None = Field(
        default=None, description='ISO 4762 size of the frame\'s screws, such as "M5"; default: by cylinder diameter'
    )
    disc_diameter: u.Size | None = Field(
        default=None, description="of the brake's disc; default: 0.7 of the cylinder's diameter, or as studs let it"
    )
    disc_thickness: u.Thickness = Field(default=0.003, description="of the brake's disc")
    pad_friction: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.25, description="friction coefficient of the brake's pads; nylon on aluminium"
    )
