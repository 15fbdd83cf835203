"""From what a joint shall do to what it is: hose, cylinder, cam, strap, and a complete description of the machine.

| symbol | meaning | unit |
|---|---|---|
| T, P | torque that is wanted, gauge supply pressure | N m, Pa |
| S | full travel of the output: the working stroke and a reserve | rad |
| V | volume that one hose sweeps; V = T S/P is needed | m3 |
| w, D | width of the flat hose, diameter of the cylinder | m |

Everything that is not sized is taken from the paper's small joint, by its built-in description.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from math import ceil, degrees, isfinite, pi, radians
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Self

from scipy.optimize import brentq

from layflat.description import units as u
from layflat.design import straplines
from layflat.design.cam import Cam, synthesise
from layflat.design.characteristic import Characteristic, of_cylinder
from layflat.design.mass import joint_mass
from layflat.design.outline import cam_outline
from layflat.design.rules import LEAST_SLOT, Finding
from layflat.design.sized import SizedJoint, description, description_text
from layflat.design.strap import bending_stress
from layflat.design.summary import JointDesign, design_joint
from layflat.errors import DesignError
from layflat.files import whole_file
from layflat.machine import Joint, Machine, load
from layflat.machine.parts import Strap
from layflat.physics.hose import peeled_volume

MODEL = "paper-small-joint"
"""The machine that a sized joint is laid over."""

HOSE_WIDTHS = tuple(w * 1e-3 for w in (40, 53, 67, 83, 102, 105, 110, 129, 160, 205, 260, 310))
"""Flat widths, m, in which layflat hose is commonly sold (inch sizes 1 to 8; makers differ by a millimetre or two)."""

SLIMMEST, STOUTEST = 0.8, 1.0
"""Cylinder diameter over hose width when both are chosen here. The paper's joints: 0.95 and 0.93."""

GIVEN_SLIMMEST, GIVEN_STOUTEST = 0.5, 1.8
"""The same when the width is given: beyond these the hose kinks, or is nearly all dead volume."""

RESERVE = radians(40.0 / 3.0)
"""Full travel beyond the working stroke, as in the paper's large joint: two thirds of the way to the stop."""

WIDER = 4
"""How many hoses beyond the narrowest are tried before the strap is called too weak."""

LARGEST_ROLLER = 0.8
"""Roller radius over the cylinder's beyond which a cam doesn't fit."""

CONTACT_SHARE = 0.7
"""Contact angle at full travel over wrap: 84 deg of 120 deg in Table 1."""

OFFSET_SHARES = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85)
"""Shaft offset over cylinder radius: the first at which the strap clears the cylinder's free edge is taken."""

STRAP_THICKNESSES = tuple(t * 1e-3 for t in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3))
STRAP_SHARE = 0.45
"""Greatest width of a strap over the hose's: two opposing straps pass each other."""

LEAST_STRAP = 0.012
LAYERS = (2, 4)

INERTIA_PER_TORQUE = 1e-2
"""Payload inertia that a joint carries, kg m2 per N m. Source: section 5."""

RANGES: dict[str, tuple[float, float, float, str]] = {
    "torque": (0.5, 1500.0, 1.0, "N m"),
    "stroke": (radians(30.0), radians(200.0), 180 / pi, "deg"),
    "supply": (0.5e5, 10e5, 1e-5, "bar"),
    "wrap": (radians(60.0), pi, 180 / pi, "deg"),
    "hose_width": (0.03, 0.4, 1e3, "mm"),
    "cylinder_diameter": (0.02, 0.6, 1e3, "mm"),
    "strap_width": (0.003, 0.3, 1e3, "mm"),
    "strap_thickness": (0.02e-3, 1e-3, 1e3, "mm"),
    "payload_inertia": (1e-5, 1e3, 1.0, "kg m^2"),
    "stress_margin": (1.0, 10.0, 1.0, ""),
}
"""Sensible range of each request: least and greatest in SI, factor and unit in which a message gives them."""

KINDS = {
    "torque": u.TORQUE, "stroke": u.ANGLE, "supply": u.PRESSURE, "wrap": u.ANGLE, "hose_width": u.LENGTH,
    "cylinder_diameter": u.LENGTH, "strap_width": u.LENGTH, "strap_thickness": u.LENGTH, "payload_inertia": u.INERTIA,
}  # fmt: skip


@dataclass(frozen=True)
class SizingRequest:
    """What a joint shall do, in SI; what is None is chosen.

    Args:
        torque: over the whole working stroke at supply pressure, N m.
        stroke: working stroke, rad.
        supply: gauge supply pressure, Pa.
        wrap: wrap angle of the collapsed hose, rad.
        hose_width: width of the flat hose, m.
        cylinder_diameter: m.
        strap_width: m.
        strap_thickness: m.
        payload_inertia: about the joint, kg m2; the paper's 10^-2 kg m2 per N m if None.
        stress_margin: yield over stress that the strap must keep.
        name: of the machine.

    Raises:
        DesignError: a value lies outside any sensible range.
    """

    torque: float
    stroke: float
    supply: float
    wrap: float = radians(120.0)
    hose_width: float | None = None
    cylinder_diameter: float | None = None
    strap_width: float | None = None
    strap_thickness: float | None = None
    payload_inertia: float | None = None
    stress_margin: float = 1.5
    name: str = "sized-joint"

    def __post_init__(self) -> None:
        for key, (least, greatest, factor, unit) in RANGES.items():
            value = getattr(self, key)
            if value is not None and not (isfinite(value) and least * (1 - 1e-9) <= value <= greatest * (1 + 1e-9)):
                raise DesignError(
                    f"{value * factor:.6g} {unit}".rstrip(),
                    where=f"size: {key}",
                    right=f"give {least * factor:.4g} to {greatest * factor:.4g} {unit}".rstrip(),
                )

    @classmethod
    def from_text(cls, **given: str | float | None) -> Self:
        """A request from texts with units, such as torque="25 N m"; what is None keeps its default.

        Raises:
            InputError: a text is no quantity of its kind.
            DesignError: a value lies outside any sensible range.
        """
        values: dict[str, Any] = {}
        for key, value in given.items():
            if value is not None:
                values[key] = u.quantity(value, KINDS[key], f"size: {key}") if key in KINDS else value
        for key in ("torque", "stroke", "supply"):
            if key not in values:
                raise DesignError("is missing", where=f"size: {key}", right=f'give one such as "{KINDS[key].example}"')
        return cls(**values)


@dataclass(frozen=True)
class Sized:
    """A sized joint.

    Args:
        request: what it was sized for.
        tables: the description as nested tables; each value with its provenance.
        toml: the description as text.
        machine: the machine that this text describes.
        design: its design at supply pressure.
    """

    request: SizingRequest
    tables: dict[str, Any]
    toml: str
    machine: Machine
    design: JointDesign

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warnings and notes of the design rules."""
        return self.design.findings

    def write(self, path: Path) -> Path:
        """Write the description to a TOML file.

        Raises:
            OutputError: it can't be written there.
        """
        with whole_file(path) as temporary:
            temporary.write_text(self.toml, encoding="utf-8", newline="\n")
        return path


def size_joint(request: SizingRequest) -> Sized:
    """Size a joint: the narrowest hose on a cylinder of the paper's proportions that gives torque and stroke.

    Where its strap would not bear the tension, the next wider hose is tried, up to `WIDER` times.

    Raises:
        DesignError: no joint can do what is asked, in one line that says why.
    """
    model = load(MODEL)
    base = next(iter(model.joints.values()))
    refused: DesignError | None = None
    for width, diameter in islice(_hoses_and_cylinders(request, base.hose.peel_ratio), 1 + WIDER):
        try:
            return _described(request, model, base, _sized(request, base, width, diameter))
        except DesignError as error:
            refused = refused or error
    raise refused or _too_much(request)


def _sized(request: SizingRequest, base: Joint, width: float, diameter: float) -> Joint:
    """The model's joint with hose, cylinder and roller of the sizes that were found."""
    contact_end = CONTACT_SHARE * request.wrap
    peeled = (request.wrap - contact_end) * base.hose.peel_ratio * diameter / 2
    radius = ceil(peeled / (request.stroke + RESERVE) * 1e5) / 1e5
    if radius >= LARGEST_ROLLER * diameter / 2:
        raise DesignError(
            f"{degrees(request.stroke):.4g} deg is too short a stroke for the cam to fit into the cylinder",
            where="size: stroke",
            right="ask for a longer stroke, or a smaller wrap",
        )
    scale = diameter / base.cylinder.diameter
    return base.model_copy(
        update={
            "hose": base.hose.model_copy(update={"width": width, "wrap": request.wrap, "contact_end": contact_end}),
            "cylinder": base.cylinder.model_copy(
                update={"diameter": diameter, "wall": _half_mm(base.cylinder.wall * scale)}
            ),
            "output": base.output.model_copy(update={"radius": radius, "kind": "cam"}),
            "cover": base.cover.model_copy(update={"thickness": _half_mm(base.cover.thickness * scale)}),
        }
    )


def _described(request: SizingRequest, model: Machine, base: Joint, joint: Joint) -> Sized:
    """Cam and strap for a joint of settled size; then its description, read back as a user would."""
    characteristic = of_cylinder(joint)
    joint, cam = _with_shaft(request, joint, characteristic)
    outline = cam_outline(cam)
    tension = float(cam.tension.max()) * request.supply
    joint = joint.model_copy(update={"strap": _strap(request, base.strap, joint, tension, cam.smallest_radius)})
    share = _counted_share(model)
    sized = SizedJoint(
        joint=joint,
        torque_constant=cam.torque_constant,
        swept_volume=characteristic.swept_volume,
        mass=joint_mass(joint, characteristic.full_travel, outline).counted / share,
        torque=request.torque,
        stroke=request.stroke,
        supply=request.supply,
        payload_inertia=request.payload_inertia or INERTIA_PER_TORQUE * request.torque,
    )
    tables = description(sized, model, MODEL, request.name)
    text = description_text(tables)
    machine = _read_back(text)
    design = design_joint(machine)
    if design.mean_torque < request.torque or design.stroke < request.stroke:
        raise DesignError(
            f"came out at {design.mean_torque:.4g} N m over {degrees(design.stroke):.4g} deg",
            where="size",
            right="ask for a little less, or give hose_width and cylinder_diameter",
        )
    return Sized(request, tables, text, machine, design)


def _with_shaft(request: SizingRequest, joint: Joint, characteristic: Characteristic) -> tuple[Joint, Cam]:
    """The joint with its shaft where the strap clears the cylinder, or dips least, and the cam for it."""
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
        raise DesignError(
            f"with a wrap of {degrees(request.wrap):.4g} deg and a stroke of {degrees(request.stroke):.4g} deg "
            "no place of the shaft gives a cam",
            where="size: wrap",
            right="ask for a longer stroke, or a wrap nearer to 120 deg",
        )
    return best


def _hoses_and_cylinders(request: SizingRequest, c: float) -> Iterator[tuple[float, float]]:
    """Widths of hose and diameters of cylinder that sweep the volume that is needed, m, the smallest first."""
    needed = request.torque * (request.stroke + RESERVE) / request.supply
    chosen = request.hose_width is None and request.cylinder_diameter is None
    least, greatest = (SLIMMEST, STOUTEST) if chosen else (GIVEN_SLIMMEST, GIVEN_STOUTEST)
    for width in HOSE_WIDTHS if request.hose_width is None else (request.hose_width,):
        D = request.cylinder_diameter
        if D is None:
            fit = _diameter(request, width, needed, c, least=least, greatest=greatest)
            if fit is not None:
                yield width, fit
        elif least * width <= D <= greatest * width and _swept(request, width, D, c) >= needed:
            yield width, D


def _diameter(
    request: SizingRequest, width: float, needed: float, c: float, *, least: float, greatest: float
) -> float | None:
    """Smallest cylinder for a hose, in whole millimetres, or None where even the largest is too small."""

    def short(D: float) -> float:
        return _swept(request, width, D, c) - needed

    if short(greatest * width) < 0:
        return None
    D = least * width if short(least * width) >= 0 else float(brentq(short, least * width, greatest * width))
    D = ceil(D * 1e3 - 1e-9) / 1e3
    return D if short(D) >= 0 else None


def _swept(request: SizingRequest, width: float, D: float, c: float) -> float:
    return float(peeled_volume(D / 2, width / pi, request.wrap, CONTACT_SHARE * request.wrap, c))


def _too_much(request: SizingRequest) -> DesignError:
    if request.cylinder_diameter is not None:
        what, better = f"a cylinder of {request.cylinder_diameter * 1e3:.4g} mm", "a larger cylinder"
    elif request.hose_width is not None:
        what, better = f"a hose of {request.hose_width * 1e3:.4g} mm", "a wider hose"
    else:
        what, better = f"the widest hose sold, {HOSE_WIDTHS[-1] * 1e3:.4g} mm,", "more supply pressure"
    return DesignError(
        f"{what} can't give {request.torque:.4g} N m over {degrees(request.stroke):.4g} deg "
        f"at {request.supply / 1e5:.4g} bar",
        where="size",
        right=f"give {better}, or ask for less torque or stroke",
    )


def _strap(request: SizingRequest, base: Strap, joint: Joint, tension: float, bend_radius: float) -> Strap:
    """The narrowest strip of the model's steel that bears tension and bending with the margin that is wanted."""
    allowed = base.yield_stress / request.stress_margin
    widest = request.strap_width or STRAP_SHARE * joint.hose.width
    thicknesses = STRAP_THICKNESSES if request.strap_thickness is None else (request.strap_thickness,)
    for layers in LAYERS:
        fits = []
        for t in thicknesses:
            left = allowed - bending_stress(base.modulus, t, bend_radius)
            if left > 0:
                width = max(LEAST_STRAP, ceil(tension / (t * layers * left) * 1e3) / 1e3)
                fits.append((width, t))
        if fits and min(fits)[0] <= widest:
            width, t = min(fits)
            chosen = request.strap_width or width
            return base.model_copy(update={"width": chosen, "thickness": t, "layers": layers})
    raise DesignError(
        f"no strap up to {widest * 1e3:.4g} mm wide bears {tension:.4g} N around {bend_radius * 1e3:.4g} mm "
        f"with a margin of {request.stress_margin:.3g}",
        where="size: strap",
        right="a shorter stroke bends it less, a lower supply pressure pulls less; or ask for a smaller stress_margin",
    )


def _half_mm(value: float) -> float:
    return max(1e-3, round(value * 2e3) / 2e3)


def _counted_share(model: Machine) -> float:
    """Mass of the counted parts over the whole mass of the model's joint."""
    mass = design_joint(model).mass
    return mass.counted / mass.body


def _read_back(text: str) -> Machine:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "sized.toml"
        path.write_text(text, encoding="utf-8")
        return load(path)
