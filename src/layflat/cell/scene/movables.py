"""Moving parts of the scene besides the arm's links: fruit, and lift and cup at the arm's tip."""

from math import pi
from typing import Any

import numpy as np

from layflat.cell.extras import NO_CONTACT, add_geom, mujoco
from layflat.cell.file.model import Cell
from layflat.cell.scene.produce import CAP_HEIGHT_RATIO, STEM_RADIUS_RATIO, SceneFruit

GREEN = (0.20, 0.42, 0.12, 1.0)
HOLLOW_COLOUR = (0.36, 0.36, 0.12, 1.0)
BROWN = (0.30, 0.20, 0.10, 1.0)
STEM_COLOUR = (0.86, 0.80, 0.70, 1.0)
STEEL_COLOUR = (0.70, 0.72, 0.74, 1.0)
LINK_COLOUR = (0.75, 0.77, 0.80, 1.0)
DRUM_COLOUR = (0.16, 0.30, 0.52, 1.0)
RUBBER_COLOUR = (0.12, 0.12, 0.13, 1.0)
SEPAL_COUNT = 5  # sepals of a tomato's calyx
BELT_CONTACT_BIT = 2  # of contacts with a conveyor's plate, which only fruit and cup touch
CUP_HEIGHT = 0.012  # m


def add_fruit(spec: Any, cell: Cell, fruit: SceneFruit) -> None:
    """Add a fruit as a free body, and the inactive weld by which the cup can hold it.

    Args:
        spec: MjSpec.
        cell: description with the kind's friction.
        fruit: fruit to be added.
    """
    mj = mujoco()
    body = spec.worldbody.add_body(name=fruit.name, pos=list(fruit.position), quat=list(fruit.orientation))
    body.add_freejoint(name=fruit.name)
    material = spec.add_material(name=fruit.name, rgba=[*fruit.rgb, 1.0], specular=0.35, shininess=0.4)
    kind = cell.produce[fruit.kind]
    touch = {"condim": 6, "conaffinity": 1 | BELT_CONTACT_BIT, "friction": [kind.friction, kind.rolling, kind.rolling]}
    radius, height_above = fruit.diameter / 2, fruit.height_above
    whole = fruit.shape == "round"
    skin = {"size": (radius, radius, height_above), "material": material.name}
    add_geom(body, "ellipsoid", fruit.name, mass=(1.0 if whole else 0.9) * fruit.mass, **skin, **touch)
    if not whole:
        half = (1 - CAP_HEIGHT_RATIO / 2) * fruit.height / 2
        stem = {"size": (STEM_RADIUS_RATIO * fruit.diameter, half), "pos": [0.0, 0.0, -half], "mass": 0.1 * fruit.mass}
        add_geom(body, "cylinder", f"{fruit.name}.stem", rgba=STEM_COLOUR, **stem, **touch)
    _add_top(spec, body, fruit)
    spec.add_equality(
        name=f"hold.{fruit.name}", type=mj.mjtEq.mjEQ_WELD, objtype=mj.mjtObj.mjOBJ_BODY,
        name1="cup", name2=fruit.name, active=False, solref=[0.006, 1.0],
    )  # fmt: skip


def _add_top(spec: Any, body: Any, fruit: SceneFruit) -> None:
    """Add a calyx or stalk, which is visible and without contacts."""
    radius, height_above, ghost = fruit.diameter / 2, fruit.height_above, {"mass": 0.0, **NO_CONTACT}
    if fruit.top == "calyx":
        name = f"{fruit.name}.calyx"
        spec.add_mesh(name=name, **_star_mesh(0.42 * radius, 0.08 * radius))
        add_geom(body, "mesh", "", meshname=name, pos=[0.0, 0.0, 0.985 * height_above], rgba=GREEN, **ghost)
    elif fruit.top == "stalk":
        hollow = {"size": (0.16 * radius, 0.16 * radius, 0.03 * radius), "pos": [0.0, 0.0, 0.98 * height_above]}
        add_geom(body, "ellipsoid", "", rgba=HOLLOW_COLOUR, **hollow, **ghost)
        along = [0.0, 0.0, 0.95 * height_above, 0.05 * radius, 0.0, 1.06 * height_above]
        add_geom(body, "capsule", "", fromto=along, size=(0.045 * radius,), rgba=BROWN, **ghost)


def _star_mesh(radius: float, thick: float) -> dict[str, list[float] | list[int]]:
    """Return a flat star, the mesh of a calyx (m): arguments `uservert` and `userface` of MuJoCo's `add_mesh`."""
    corner = np.arange(2 * SEPAL_COUNT)
    turn, far = pi * corner / SEPAL_COUNT, radius * np.where(corner % 2, 0.25, 1.0)
    rim = np.stack([far * np.cos(turn), far * np.sin(turn), 0.0 * far], axis=1)
    points = np.vstack([rim, [[0.0, 0.0, thick / 2], [0.0, 0.0, -thick / 2]]])
    after, over, under = np.roll(corner, -1), len(rim) + 0 * corner, len(rim) + 1 + 0 * corner
    faces = np.vstack([np.stack([corner, after, over], axis=1), np.stack([after, corner, under], axis=1)])
    return {"uservert": points.ravel().tolist(), "userface": faces.ravel().tolist()}


def add_shapes(spec: Any, cell: Cell) -> None:
    """Add the arm's shapes without mass: a drum around each joint, two tubes for each link."""
    for name, joint in cell.machine.joints.items():
        link, radius = spec.joint(name).parent, joint.cylinder.diameter / 2
        add_geom(link, "cylinder", f"{name}.drum", size=(radius, joint.body.height / 2), rgba=DRUM_COLOUR, mass=0.0)
        for side in (-1.0, 1.0):
            along = [0.0, side * 0.6 * radius, 0.0, joint.planar_link.length, side * 0.018, 0.0]
            add_geom(
                link, "capsule", f"{name}.tube{side:+.0f}", fromto=along, size=(0.009,), rgba=LINK_COLOUR, mass=0.0
            )


def add_tool(spec: Any, cell: Cell) -> None:
    """Add lift and cup at the tip of the arm: slide joint `lift`, positive downwards, and its motor `lift`."""
    mj = mujoco()
    last = list(cell.machine.joints)[-1]
    tip = spec.joint(last).parent
    lift, cup = cell.lift, cell.cup
    x, lip = cell.machine.joint[last].planar_link.length, lift.clearance - cell.mount.height
    cylinder = [x, 0.0, 0.05, x, 0.0, lip + CUP_HEIGHT + 0.035]
    add_geom(tip, "cylinder", "lift.cylinder", fromto=cylinder, size=(0.016,), rgba=STEEL_COLOUR, mass=0.0)
    body = tip.add_body(name="cup", pos=[x, 0.0, lip], gravcomp=1.0)
    limited = {"range": [0.0, lift.stroke], "limited": mj.mjtLimited.mjLIMITED_TRUE}
    body.add_joint(name="lift", type=mj.mjtJoint.mjJNT_SLIDE, axis=[0, 0, -1], **limited)
    rod = {"fromto": [0.0, 0.0, CUP_HEIGHT, 0.0, 0.0, lift.stroke + 0.06], "mass": 0.9 * lift.mass}
    add_geom(body, "cylinder", "cup.rod", size=(0.005,), rgba=STEEL_COLOUR, **rod)
    lips = {"fromto": [0.0, 0.0, 0.0, 0.0, 0.0, CUP_HEIGHT], "mass": 0.1 * lift.mass}
    add_geom(
        body,
        "cylinder",
        "cup",
        size=(cup.diameter / 2,),
        rgba=RUBBER_COLOUR,
        condim=4,
        conaffinity=1 | BELT_CONTACT_BIT,
        **lips,
    )
    body.add_site(name="cup", size=[0.002, 0.002, 0.002], rgba=[0, 0, 0, 0])
    motor = spec.add_actuator(name="lift", trntype=mj.mjtTrn.mjTRN_JOINT, target="lift")
    motor.set_to_motor()
    motor.forcelimited = mj.mjtLimited.mjLIMITED_TRUE
    motor.forcerange = [-lift.force, lift.force]
