"""Description of the parts of a joint: hose, cylinder, output, strap, cover, brake, stops, link.

All numbers are SI floats once validated; keys that end in `_gauge` are gauge pressures.
"""

from math import pi, radians
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from layflat.description import Part, ordered
from layflat.description import units as u
from layflat.description.wrong import INPUT_VALUE, value_error
from layflat.errors import MachineError
from layflat.kinds import AnyKindOf
from layflat.machine.build_sizes import Build
from layflat.machine.gains import Gains
from layflat.machine.tube import TubePart
from layflat.physics.friction import FRICTION, FrictionPart
from layflat.physics.hose import HoseGeometry
from layflat.physics.hysteresis import HYSTERESIS, LossesPart

CLAMPED_LENGTH = 0.03  # length of hose that the clamp takes from each end, m
CYLINDER_LENGTH_RATIO = 1.2  # length of the cylinder over the hose's width: room for the end plates
STRAP_LENGTH_RATIO = 1.5  # length of the strap, clamped ends included, over full travel plus the cylinder's radius

JOINT_MASS_RATIO = 3.2
"""Mass of a whole joint over that of `part_masses`, as in the paper's small joint (2 kg)."""


def _check_wrap(wrap: float) -> float:
    """Return a wrap angle, rad; raise ValueError if it is over 180 deg."""
    if wrap > radians(180.0001):
        raise value_error("is over 180 deg", 'give an angle such as "120 deg"', INPUT_VALUE)
    return wrap


class Hose(Part):
    """A layflat hose, wrapped around the cylinder."""

    width: u.Size = Field(description="width of the flat hose, along the cylinder's axis")
    wrap: Annotated[u.PositiveAngle, AfterValidator(_check_wrap)] = Field(
        description="wrap angle of the collapsed hose (gamma)"
    )
    contact_end: u.PositiveAngle = Field(description="contact angle at full travel (alpha)")
    peel_ratio: u.Ratio = Field(description="roller angle per contact angle, in units of R/r")
    dead_volume: u.PartVolume = Field(
        description="air in collapsed hose and fittings; in the tube as well where no line is described"
    )
    compliance: u.Compliance = Field(description="volume gained per pressure by the stretching wall")
    wall_conductance: u.HeatConductance = Field(description="heat flow from wall to air per kelvin")
    areal_mass: u.AreaDensity = Field(description="mass of one layer of hose per area")
    loss_fraction: u.Share = Field(description="loop height / torque, with a free outer surface, at reference pressure")
    torque_factor: u.Ratio = Field(
        default=1.0, description="measured torque over that of Eq. (1); of its volume likewise"
    )
    folded: bool = Field(
        default=True, description="folded back on itself, or of a single thickness: no difference in loss"
    )

    _peels = ordered(
        "contact_end", "wrap", "contact_end must be smaller than wrap, for example 84 deg with a wrap of 120 deg"
    )


class Cylinder(Part):
    """The outer cylinder that the hose is wrapped around."""

    diameter: u.Size
    wall: u.Thickness = Field(description="thickness of its wall")
    density: u.Density


class OutputElement(Part):
    """Part that the strap turns: a round roller, or a cam that keeps the torque constant."""

    kind: Literal["roller", "cam"]
    radius: u.Size = Field(description="radius of the round roller; a cam keeps this roller's stroke and mean torque")
    shaft_offset: u.LengthOrZero = Field(
        default=0.0, description="distance of the output axis from the cylinder's axis"
    )


class Strap(Part):
    """Strap from hose or shell to the output."""

    material: str
    width: u.Size
    thickness: u.Thickness
    fibre: u.LengthOrZero = Field(default=0.0, description="diameter of the fibres of a woven strap; 0 for a solid one")
    layers: Annotated[int, Field(ge=1, le=100)] = 1
    modulus: u.Stress
    yield_stress: u.Stress
    density: u.Density
    loss_fraction: u.Share = Field(description="loop height / torque that the strap adds at reference pressure")


class Cover(Part):
    """Cover on the hose's outer surface; it limits how far the hose distorts."""

    kind: Literal["none", "plate", "polythene", "shell"]
    loss_factor: u.Share = Field(description="fraction of the hose's loss that remains")
    thickness: u.LengthOrZero
    density: u.Density


class DeflectingRoller(Part):
    """Rollers that lead the strap from the hose to the output."""

    diameter: u.Size
    count: Annotated[int, Field(ge=1, le=100)]
    friction_fraction: u.Share = Field(description="loop height / torque that the pin of each roller adds")
    bending_fraction: u.Share = Field(description="the same of bending a strap as thick as the roller's diameter")


class Calliper(Part):
    """A pneumatic actuator that closes the brake, in place of a spring: the controller commands its torque."""

    released_fraction: u.Share = Field(description="fraction of the brake's torque that stays when it is released")
    stroke_time: u.ShortTime = Field(description="from none of the torque to all of it")


class Brake(Part):
    """Friction on the output shaft: the brake, and viscous drag of the bearings.

    Its dependence on velocity and on the bearings' load is described by the joint's `friction`.
    """

    torque: u.Torque = Field(description="torque at which the brake slips, at full brake signal")
    viscous: u.Damping
    calliper: Calliper | None = Field(default=None, description="default: the brake is held by a spring")


class Stops(Part):
    """Strokes of a joint and its end stops."""

    working_stroke: u.PositiveAngle
    mechanical_stroke: u.PositiveAngle
    squeeze_stiffness: u.Stiffness = Field(description="of the collapsed hose when it is compressed near the stop")
    stop_stiffness: u.Stiffness
    stop_damping: u.Damping

    _ordered = ordered(
        "working_stroke",
        "mechanical_stroke",
        "mechanical_stroke must not be smaller than working_stroke, for example 140 deg and 120 deg",
        may_equal=True,
    )


class PlanarLink(Part):
    """The rigid link that the joint turns, and the masses that turn with it."""

    length: u.Size
    mass: u.LinkMass
    centre: u.LengthOrZero = Field(
        default_factory=float,
        description="distance of the link's centre of mass from the joint; default: half its length",
    )
    inertia: u.InertiaOrZero = Field(
        default_factory=float, description="about the link's centre of mass; default: that of a uniform rod, m l^2 / 12"
    )
    rotor_inertia: u.Inertia = Field(description="of cams, shaft and brake disk about the joint")

    @model_validator(mode="after")
    def _derive_centre_and_inertia(self) -> Self:
        """Set centre (m) and inertia (kg m2) of a slender rod where they are not described."""
        derived = {"centre": self.length / 2, "inertia": self.mass * self.length**2 / 12}
        self.__dict__.update({name: derived[name] for name in derived.keys() - self.model_fields_set})
        return self


class JointBody(Part):
    """Mass and height of a whole joint, as a load of the link before it."""

    mass: u.Mass = Field(
        default_factory=float, description="of the whole joint; default: estimated from the sizes of its parts"
    )
    height: u.Size


class RegulatorPart(Part):
    """A proportional pressure regulator before the valve, by which the controller sets the stiffness of the joint."""

    min_fraction: u.Share = Field(description="fraction of the supply's gauge pressure down to which it regulates")
    stroke_time: u.ShortTime = Field(description="from none of the gauge pressure to all of it")


class Spring(Part):
    """A spring on the shaft: it returns a joint with a single hose, or bears part of the arm's weight."""

    torque: u.AnyTorque = Field(description="at mid-stroke; one above 0 moves the joint forward, as hose A does")
    stiffness: u.Stiffness = Field(default=0.0, description="decrease of that torque over the angle forward")


class Joint(Part):
    """A joint; single-acting with one hose, which turns it forward, or double-acting with two antagonistic hoses."""

    acting: Literal["single", "double"]
    hose: Hose
    cylinder: Cylinder
    output: OutputElement
    strap: Strap
    cover: Cover
    losses: Annotated[LossesPart, AnyKindOf(HYSTERESIS)]
    brake: Brake
    stops: Stops
    link: PlanarLink | None = Field(default=None, description="of a planar arm")
    body: JointBody
    deflecting_roller: DeflectingRoller | None = None
    friction: Annotated[FrictionPart, AnyKindOf(FRICTION)] | None = None
    line: TubePart | None = Field(default=None, description="tube from the valve to each hose; default: the machine's")
    regulator: RegulatorPart | None = Field(default=None, description="default: the valve gets the supply as it is")
    spring: Spring | None = Field(default=None, description="default: none")
    build: Build | None = Field(default=None, description="sizes of its parts; default: all by rules")
    gains: Gains | None = None
    valve_size: u.Ratio = Field(
        default=1.0, description="flow of this joint's valve over that of `valve`, open or shut"
    )

    @model_validator(mode="after")
    def _derive_body_mass(self) -> Self:
        """Set the mass of the body (kg) from its sizes, unless it is described."""
        if "mass" not in self.body.model_fields_set:
            body = self.body.model_copy()
            body.__dict__["mass"] = body_mass(self)
            self.__dict__["body"] = body
        return self

    @property
    def geometry(self) -> HoseGeometry:
        """Geometry of either hose on the cylinder."""
        hose, R = self.hose, self.cylinder.diameter / 2
        return HoseGeometry(hose.width, R, hose.wrap, hose.contact_end, hose.peel_ratio, hose.torque_factor)

    @property
    def planar_link(self) -> PlanarLink:
        """Link of the joint in a planar arm; raise MachineError if it has none."""
        if self.link is None:
            raise MachineError("joint has no link of a planar arm", right="describe it as [joint.NAME.link]")
        return self.link

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        """Raise ValueError if sizes of hose, cylinder and output misfit, or a single-acting joint has a regulator."""
        if self.output.radius >= self.cylinder.diameter / 2:
            radius, limit = f"{1e3 * self.output.radius:g} mm", f"{500.0 * self.cylinder.diameter:g} mm"
            raise ValueError(f"output.radius is {radius}; give less than the cylinder's radius, {limit}")
        if self.acting == "single" and self.regulator is not None:
            raise ValueError("regulator needs two hoses: the pressure in a single one is its torque; leave it out")
        if self.hose.width * 4 <= self.cylinder.diameter * (self.hose.wrap - self.hose.contact_end):
            raise ValueError("hose.width is too small for this cylinder and wrap: Eq. (1) would give no torque")
        return self


def part_masses(joint: Joint, full_travel: float, output_area: float) -> dict[str, float]:
    """Return the estimated masses of the parts of a joint, kg, those of both hoses together.

    Keys are "cylinder", "hose", "cover", "strap", and "roller" or "cam", the kind of the output.

    Args:
        joint: the described joint.
        full_travel: travel of the strap point, m.
        output_area: area of the cam or roller along its axis, m2; it has the cylinder's material and the strap's width.
    """
    hose, tube, cover, strap = joint.hose, joint.cylinder, joint.cover, joint.strap
    hoses = 2 if joint.acting == "double" else 1
    R = tube.diameter / 2
    wrapped = R * hose.wrap
    strap_length = STRAP_LENGTH_RATIO * (full_travel + R)
    return {
        "cylinder": pi * (tube.diameter - tube.wall) * tube.wall * CYLINDER_LENGTH_RATIO * hose.width * tube.density,
        "hose": hoses * 2 * hose.width * (wrapped + CLAMPED_LENGTH) * hose.areal_mass,
        "cover": hoses * wrapped * hose.width * cover.thickness * cover.density,
        "strap": hoses * strap.width * strap.thickness * strap.layers * strap_length * strap.density,
        joint.output.kind: hoses * output_area * strap.width * tube.density,
    }


def body_mass(joint: Joint) -> float:
    """Return the estimated mass of a whole joint, kg; a cam counts as the roller that it replaces."""
    area = pi * joint.output.radius**2
    return JOINT_MASS_RATIO * sum(part_masses(joint, joint.geometry.full_travel(), area).values())
