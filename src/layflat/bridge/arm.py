"""A machine's arm as a MuJoCo model: the rigid bodies that our own laws (physics/arm.py) have."""

from math import cos, sin, sqrt
from typing import Any

from layflat import extras
from layflat.machine import Machine
from layflat.machine.parts import Link
from layflat.physics.step import STEP

STANDARD_GRAVITY = 9.80665  # m/s2
POINT = 1e-9  # inertia of a point mass, kg m2: MuJoCo wants some
THICK = 0.02  # radius of what is drawn, m


def engine() -> Any:
    """Import the package `mujoco`; raise MissingExtraError if it is not installed."""
    return extras.module("cell", "mujoco")


def inertia_of(link: Link) -> tuple[float, float, float]:
    """Inertia of a link about its centre of mass, with the rotor that turns with it, along x (the link), y and z."""
    return link.rotor_inertia, link.inertia + link.rotor_inertia, link.inertia + link.rotor_inertia


def bodies(machine: Machine) -> list[tuple[str, Link, float]]:
    """Joint, link and mass carried at the link's end (the next joint's body), from base to tip."""
    described = list(machine.joints.items())
    carried = [joint.body.mass for _, joint in described[1:]] + [0.0]
    return [(name, joint.planar_link, mass) for (name, joint), mass in zip(described, carried, strict=True)]


def gravity_of(machine: Machine) -> tuple[float, float, float]:
    """Gravity, m/s2: what does not act in the arm's plane acts across it, downwards."""
    from layflat.machine import parameters  # noqa: PLC0415

    arm = parameters.arm(machine)
    g_x, g_y = getattr(arm, "gravity_x", 0.0), getattr(arm, "gravity_y", 0.0)
    return g_x, g_y, -sqrt(max(STANDARD_GRAVITY**2 - g_x**2 - g_y**2, 0.0))


def arm_spec(machine: Machine, *, passive: bool = False) -> Any:
    """The arm as an MjSpec that can be compiled, changed, or attached to a scene.

    It moves in the plane z = 0, x along link 1 in the middle of its stroke. Joints bear the machine's names, bodies
    these names with "-link"; the body "payload" and the site "tip" are at the tip. What is drawn touches nothing.

    Args:
        machine: whose arm it is.
        passive: with what `PneumaticJoints` brings along otherwise: stops as limits, bearings as damping, brakes as
            friction loss (which creeps).

    Raises:
        InputError: MuJoCo is not installed.
    """
    mj = engine()
    spec = mj.MjSpec()
    spec.modelname, spec.compiler.degree = machine.name, False
    spec.option.timestep, spec.option.gravity = STEP, gravity_of(machine)
    parent, at, turned = spec.worldbody, 0.0, 0.0
    for name, link, carried in bodies(machine):
        turn = (cos(turned / 2), 0.0, 0.0, sin(turned / 2))
        body = parent.add_body(name=f"{name}-link", pos=(at, 0.0, 0.0), quat=turn)
        body.explicitinertial, body.mass, body.ipos = True, link.mass, (link.centre, 0.0, 0.0)
        body.inertia = inertia_of(link)
        joint = body.add_joint(name=name, type=mj.mjtJoint.mjJNT_HINGE, axis=(0.0, 0.0, 1.0))
        if passive:
            _make_passive(mj, joint, machine, name)
        body.add_geom(
            type=mj.mjtGeom.mjGEOM_CAPSULE, fromto=(0.0, 0.0, 0.0, link.length, 0.0, 0.0), size=(THICK, 0.0, 0.0),
            contype=0, conaffinity=0,
        )  # fmt: skip
        if carried > 0.0:
            _add_point(body, f"{name}-carried", link.length, carried)
        parent, at, turned = body, link.length, machine.arm.elbow
    _add_point(parent, "payload", at, machine.arm.payload)
    parent.add_site(name="tip", pos=(at, 0.0, 0.0))
    return spec


def to_mjcf(machine: Machine) -> str:
    """The arm as MJCF, for use without our joints: `arm_spec` with `passive`."""
    spec = arm_spec(machine, passive=True)
    spec.compile()
    return str(spec.to_xml())


def _add_point(body: Any, name: str, at: float, mass: float) -> None:
    point = body.add_body(name=name, pos=(at, 0.0, 0.0))
    point.explicitinertial, point.mass, point.ipos = True, mass, (0.0, 0.0, 0.0)
    point.inertia = (POINT, POINT, POINT)


def _make_passive(mj: Any, joint: Any, machine: Machine, name: str) -> None:
    described = machine.joints[name]
    half = described.stops.mechanical_stroke / 2
    joint.range, joint.limited = (-half, half), mj.mjtLimited.mjLIMITED_TRUE
    joint.frictionloss = described.brake.torque
    joint.damping = [described.brake.viscous, 0.0, 0.0]
