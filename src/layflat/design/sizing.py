"""Size a joint: from what it is asked to do to hose, cylinder, cam, strap, and a complete description of the machine.

Everything that is not sized is taken from the paper's small joint, by its built-in description.
"""

from dataclasses import dataclass
from functools import cache
from itertools import islice
from math import ceil, degrees
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from layflat.design import straplines
from layflat.design.cam import Cam, cam_outline, synthesise
from layflat.design.characteristic import Characteristic, cylinder_characteristic
from layflat.design.joint import LEAST_SLOT, design_joint
from layflat.design.request import CONTACT_SHARE, TRAVEL_RESERVE, SizingRequest, explain_infeasible, hoses_and_cylinders
from layflat.design.sized import SizedJoint, joint_description
from layflat.design.strength import choose_strap
from layflat.design.summary import Finding, JointDesign
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.machine import Joint, Machine, load
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.machine.parts import part_masses
from layflat.physics.hose import HoseGeometry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODEL_MACHINE = "paper-small-joint-fast"  # machine that a sized joint extends; its valve has spare flow
MAX_WIDER_HOSES = 4  # number of hoses wider than the narrowest that are tried, if the strap is too weak
LARGEST_ROLLER = 0.8  # roller radius over the cylinder's above which a cam doesn't fit
# Shaft offsets over cylinder radius, tried in order until the strap clears the cylinder's free edge.
OFFSET_SHARES = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85)


@dataclass(frozen=True)
class Sized:
    """Sized joint, with its description and design."""

    request: SizingRequest
    toml: str  # description, each value with its provenance
    machine: Machine  # of this description
    design: JointDesign  # at supply pressure

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warnings and notes of the design rules."""
        return self.design.findings

    def write(self, path: Path) -> Path:
        """Write the description to a TOML file; raise OutputError if it can't be written there."""
        return write_text(path, self.toml)

    def plot(self) -> "Figure":
        """Draw the joint's torque and its cam, as its design does."""
        return self.design.plot()

    def _repr_html_(self) -> str:
        return self.design._repr_html_()


@cache
def model_machine() -> Machine:
    """Return the machine that the descriptions of sized joints extend."""
    return load(MODEL_MACHINE)


@cache
def _counted_share() -> float:
    """Return the mass of the model joint's counted parts over that of the whole joint."""
    mass = design_joint(model_machine()).mass
    return mass.counted / mass.body


def size_joint(request: SizingRequest) -> Sized:
    """Size a joint: choose the narrowest hose, on a cylinder of the paper's proportions, that yields torque and stroke.

    If no strap withstands the tension, the next wider hose is tried, up to `MAX_WIDER_HOSES` times. Raise DesignError
    if no joint meets the request.

    Example:
        >>> import layflat as lf
        >>> sized = lf.size_joint(lf.SizingRequest(torque="25 N m", stroke="120 deg", supply="4 bar"))
        >>> sized.design.joint.hose.width, sized.design.mean_torque
        (0.105, 25.0)
        >>> path = lf.save(sized.machine, "my-joint.toml")
    """
    base = next(iter(model_machine().joints.values()))
    refused: DesignError | None = None
    for width, diameter in islice(hoses_and_cylinders(request, base.hose.peel_ratio), 1 + MAX_WIDER_HOSES):
        try:
            return _described(request, base, _sized(request, base, width, diameter))
        except DesignError as error:
            refused = refused or error
    raise refused or explain_infeasible(request)


def _sized(request: SizingRequest, base: Joint, width: float, diameter: float) -> Joint:
    """Return the model's joint with hose and cylinder of a width and a diameter (m), and a roller that fits the stroke.

    Raises:
        DesignError: the stroke is too short for the cam to fit into the cylinder.
    """
    contact_end = CONTACT_SHARE * request.wrap
    hose = HoseGeometry(width, diameter / 2, request.wrap, contact_end, base.hose.peel_ratio)
    radius = ceil(hose.full_travel() / (request.stroke + TRAVEL_RESERVE) * 1e5) / 1e5
    if radius >= LARGEST_ROLLER * diameter / 2:
        what = f"{degrees(request.stroke):.4g} deg is too short a stroke for the cam to fit into the cylinder"
        right = "ask for a longer stroke, or a smaller wrap"
        raise DesignError(what, where="size: stroke", right=right)
    scale = diameter / base.cylinder.diameter
    updates = {
        "hose": {"width": width, "wrap": request.wrap, "contact_end": contact_end},
        "cylinder": {"diameter": diameter, "wall": _half_mm(base.cylinder.wall * scale)},
        "output": {"radius": radius, "kind": "cam"},
        "cover": {"thickness": _half_mm(base.cover.thickness * scale)},
    }
    parts = {name: getattr(base, name).model_copy(update=update) for name, update in updates.items()}
    return base.model_copy(update=parts)


def _described(request: SizingRequest, base: Joint, joint: Joint) -> Sized:
    """Choose shaft, cam and strap of a joint with hose and cylinder, and return it, built from its description.

    Raises:
        DesignError: no shaft offset or strap fits, or the result misses torque or stroke.
    """
    characteristic = cylinder_characteristic(joint)
    joint, cam = _with_shaft(request, joint, characteristic)
    area = cam_outline(cam).area
    tension = float(cam.tension.max()) * request.supply
    strap = choose_strap(request, base.strap, joint.hose.width, tension, cam.smallest_radius)
    joint = joint.model_copy(update={"strap": strap})
    parts = part_masses(joint, characteristic.full_travel, area)
    mass = sum(parts.values()) / _counted_share()
    sized = SizedJoint(request, joint, cam.torque_constant, characteristic.swept_volume, mass)
    text = joint_description(sized, model_machine(), MODEL_MACHINE)
    with TemporaryDirectory() as folder:
        place = Path(folder) / "sized.toml"
        place.write_text(text, encoding="utf-8")
        machine = build(*tables(place), f"{request.name}.toml")
    design = design_joint(machine)
    if design.mean_torque < request.torque or design.stroke < request.stroke:
        what = f"came out at {design.mean_torque:.4g} N m over {degrees(design.stroke):.4g} deg"
        right = "ask for a little less, or give hose_width and cylinder_diameter"
        raise DesignError(what, where="size", right=right)
    return Sized(request, text, machine, design)


def _with_shaft(request: SizingRequest, joint: Joint, characteristic: Characteristic) -> tuple[Joint, Cam]:
    """Return joint and cam with the first shaft offset at which the strap clears the cylinder, or dips least.

    Raises:
        DesignError: no shaft offset gives a convex cam.
    """
    stroke = characteristic.full_travel / joint.output.radius
    best: tuple[Joint, Cam] | None = None
    for share in OFFSET_SHARES:
        offset = round(share * joint.cylinder.diameter / 2, 3)
        placed = joint.model_copy(update={"output": joint.output.model_copy(update={"shaft_offset": offset})})
        try:
            cam = synthesise(characteristic, straplines.joint_strap_line(placed), stroke)
        except DesignError:
            continue
        if cam.convex and (best is None or cam.dip < best[1].dip):
            best = placed, cam
        if best is not None and best[1].dip <= LEAST_SLOT:
            break
    if best is None:
        sizes = f"a wrap of {degrees(request.wrap):.4g} deg and a stroke of {degrees(request.stroke):.4g} deg"
        right = "ask for a longer stroke, or a wrap nearer to 120 deg"
        raise DesignError(f"with {sizes} no place of the shaft gives a cam", where="size: wrap", right=right)
    return best


def _half_mm(value: float) -> float:
    return max(1e-3, round(value * 2e3) / 2e3)
