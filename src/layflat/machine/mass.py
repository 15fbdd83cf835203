"""What a joint weighs, part by part, by the sizes that its description gives.

End plates, shaft, bearings, brake and fittings are the rest of its whole mass.
"""

from math import pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from layflat.machine.parts import Joint

CLAMPED = 0.03  # length of hose that the clamp takes from each end, m
CYLINDER_LONGER = 1.2  # length of the cylinder over the hose's width: room for the end plates
STRAP_LONGER = 1.5  # length of the strap over the full travel and the cylinder's radius: what is clamped at both ends

WHOLE_PER_PARTS = 3.2
"""Mass of a whole joint over that of the parts that are counted, as in the paper's small joint (2 kg)."""


def part_masses(joint: "Joint", full_travel: float, output_area: float) -> dict[str, float]:
    """Return the estimated mass of each part of a joint, kg.

    Args:
        joint: the described joint.
        full_travel: of the strap point, m.
        output_area: of the cam or roller seen along its axis, m2; it is of the cylinder's material, as wide as the
            strap.
    """
    hose, tube, cover, strap = joint.hose, joint.cylinder, joint.cover, joint.strap
    hoses = 2 if joint.acting == "double" else 1
    R = tube.diameter / 2
    wrapped = R * hose.wrap
    strap_length = STRAP_LONGER * (full_travel + R)
    return {
        "cylinder": pi * (tube.diameter - tube.wall) * tube.wall * CYLINDER_LONGER * hose.width * tube.density,
        "hose": hoses * 2 * hose.width * (wrapped + CLAMPED) * hose.areal_mass,
        "cover": hoses * wrapped * hose.width * cover.thickness * cover.density,
        "strap": hoses * strap.width * strap.thickness * strap.layers * strap_length * strap.density,
        joint.output.kind: hoses * output_area * strap.width * tube.density,
    }


def body_mass(joint: "Joint") -> float:
    """Return the estimated mass of a whole joint, kg, with a cam as heavy as the roller that it stands for."""
    area = pi * joint.output.radius**2
    return WHOLE_PER_PARTS * sum(part_masses(joint, joint.geometry.full_travel(), area).values())
