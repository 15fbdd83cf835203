"""Size a joint: from what it is asked to do to hose, cylinder, cam, strap, and a complete description of the machine.

Everything that is not sized is taken from the paper's small joint, by its built-in description.
"""

from dataclasses import dataclass
from functools import cache
from itertools import islice
from math import ceil, degrees
from pathlib import Path
from tempfile import TemporaryDirectory

from layflat.design import straplines
from layflat.design.cam import Cam, synthesise
from layflat.design.characteristic import Characteristic, of_cylinder
from layflat.design.findings import Finding
from layflat.design.joint import design_joint
from layflat.design.outline import cam_outline
from layflat.design.request import CONTACT_SHARE, RESERVE, SizingRequest, hoses_and_cylinders, too_much
from layflat.design.rules import LEAST_SLOT
from layflat.design.sized import SizedJoint, description
from layflat.design.strength import choose_strap
from layflat.design.summary import JointDesign
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.machine import Joint, Machine, load
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.machine.parts import part_masses
from layflat.physics.hose import HoseGeometry

MODEL = "paper-small-joint-fast"  # the machine that a sized joint is laid over: its valve leaves room to move
WIDER = 4  # how many hoses beyond the narrowest are tried before the strap is called too weak
LARGEST_ROLLER = 0.8  # roller radius over the cylinder's beyond which a cam doesn't fit
# Shaft offset over cylinder radius: the first at which the strap clears the cylinder's free edge is taken.
OFFSET_SHARES = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85)


@dataclass(frozen=True)
class Sized:
    """A sized joint."""

    request: SizingRequest  # what it was sized for
    toml: str  # its description, each value with its provenance
    machine: Machine  # the machine that this text describes
    design: JointDesign  # its design at supply pressure

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warnings and notes of the design rules."""
        return self.design.findings

    def write(self, path: Path) -> Path:
        """Write the description to a TOML file; raise OutputError if it can't be written there."""
        return write_text(path, self.toml)


@cache
def model() -> Machine:
    """Return the machine that a sized joint is laid over."""
    return load(MODEL)


@cache
def _counted_share() -> float:
    mass = design_joint(model()).mass
    return mass.counted / mass.body


def size_joint(request: SizingRequest) -> Sized:
    """Size a joint: find the narrowest hose on a cylinder of the paper's proportions that gives torque and stroke.

    Where its strap would not bear the tension, the next wider hose is tried, up to `WIDER` times. Raise DesignError if
    no joint can do what is asked.
    """
    base = next(iter(model().joints.values()))
    refused: DesignError | None = None
    for width, diameter in islice(hoses_and_cylinders(request, base.hose.peel_ratio), 1 + WIDER):
        try:
            return _described(request, base, _sized(request, base, width, diameter))
        except DesignError as error:
            refused = refused or error
    raise refused or too_much(request)


def _sized(request: SizingRequest, base: Joint, width: float, diameter: float) -> Joint:
    """Return the model's joint with hose, cylinder and roller of the sizes that were found."""
    contact_end = CONTACT_SHARE * request.wrap
    hose = HoseGeometry(width, diameter / 2, request.wrap, contact_end, base.hose.peel_ratio)
    radius = ceil(hose.full_travel() / (request.stroke + RESERVE) * 1e5) / 1e5
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
    """Find cam and strap for a joint of settled size; then its description, read back as a user would."""
    characteristic = of_cylinder(joint)
    joint, cam = _with_shaft(request, joint, characteristic)
    area = cam_outline(cam).area
    tension = float(cam.tension.max()) * request.supply
    strap = choose_strap(request, base.strap, joint.hose.width, tension, cam.smallest_radius)
    joint = joint.model_copy(update={"strap": strap})
    parts = part_masses(joint, characteristic.full_travel, area)
    mass = sum(parts.values()) / _counted_share()
    sized = SizedJoint(request, joint, cam.torque_constant, characteristic.swept_volume, mass)
    text = description(sized, model(), MODEL)
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
    """Return the joint with its shaft where the strap clears the cylinder, or dips least, and the cam for it."""
    stroke = characteristic.full_travel / joint.output.radius
    best: tuple[Joint, Cam] | None = None
    for share in OFFSET_SHARES:
        offset = round(share * joint.cylinder.diameter / 2, 3)
        placed = joint.model_copy(update={"output": joint.output.model_copy(update={"shaft_offset": offset})})
        try:
            cam = synthesise(characteristic, straplines.of_joint(placed), stroke)
        except DesignError:
            continue
        if cam.convex and (best is None or cam.dip < best[1].dip):
            best = placed, cam
        if best is not None and best[1].dip <= LEAST_SLOT:
            break
    if best is None:
        asked = f"a wrap of {degrees(request.wrap):.4g} deg and a stroke of {degrees(request.stroke):.4g} deg"
        right = "ask for a longer stroke, or a wrap nearer to 120 deg"
        raise DesignError(f"with {asked} no place of the shaft gives a cam", where="size: wrap", right=right)
    return best


def _half_mm(value: float) -> float:
    return max(1e-3, round(value * 2e3) / 2e3)
