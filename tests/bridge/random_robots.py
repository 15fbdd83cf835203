"""Random arms as people write them: URDF and MJCF with whatever these formats allow, for comparison with MuJoCo."""

from math import degrees
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

ORDERS = ("xyz", "XYZ", "zyx", "ZYX", "zxz", "yXz")


class RandomRobot(NamedTuple):
    file: Path
    joints: list[str]  # of the arm
    to: str
    tool: str
    limits: list[tuple[float, float]]  # rad
    soft: list[tuple[float, float] | None]


class Dice:
    """Random numbers and choices of one seed, as texts that files have."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def number(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def numbers(self, low: float, high: float, count: int = 3) -> str:
        return " ".join(repr(self.number(low, high)) for _ in range(count))

    def chance(self, share: float = 0.5) -> bool:
        return bool(self.rng.random() < share)

    def one(self, *choices: str) -> str:
        return choices[int(self.rng.integers(len(choices)))]

    def moments(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Principal moments of a body, and their axes."""
        a, b = self.rng.uniform(1e-4, 3e-3, 2)
        c = self.rng.uniform(abs(a - b) * 1.01 + 1e-6, (a + b) * 0.99)
        return np.array([a, b, c]), np.asarray(Rotation.random(random_state=self.rng).as_matrix())

    def range(self) -> tuple[float, float]:
        low = self.number(-2.5, 1.5)
        return low, low + self.number(0.4, 2.2)


def joint_name(dice: Dice, i: int) -> str:
    return dice.one(f"joint{i}", f"arm.joint_{i}", f"a:{i}", f"Joint {i}")


def random_urdf(folder: Path, seed: int) -> RandomRobot:
    """A URDF with fixed links between, soft limits, a finger that slides and another that mimics it, and a side arm."""
    dice = Dice(seed)
    count = int(dice.rng.integers(1, 8))
    parts = ['<mujoco><compiler fusestatic="false"/></mujoco>', '<link name="base"/>']
    joints: list[str] = []
    limits: list[tuple[float, float]] = []
    soft: list[tuple[float, float] | None] = []
    parent = "base"

    def origin() -> str:
        if dice.chance(0.1):
            return ""
        turn = f' rpy="{dice.numbers(-3.0, 3.0)}"' if dice.chance(0.8) else ""
        return f'<origin xyz="{dice.numbers(-0.3, 0.3)}"{turn}/>'

    def link(name: str) -> None:
        moments, axes = dice.moments()
        inertia = axes @ np.diag(moments) @ axes.T
        six = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        values = " ".join(f'{key}="{float(inertia[at])!r}"' for key, at in six.items())
        collision = f'<collision>{origin()}<geometry><box size="1 1 1"/></geometry></collision>' * dice.chance()
        mass = f'<mass value="{dice.number(0.1, 2.0)!r}"/>'
        parts.append(f'<link name="{name}"><inertial>{origin()}{mass}<inertia {values}/></inertial>{collision}</link>')

    def joint(name: str, kind: str, before: str, after: str, more: str = "") -> None:
        ends = f'<parent link="{before}"/><child link="{after}"/>'
        parts.append(f'<joint name="{name}" type="{kind}">{origin()}{ends}{more}</joint>')

    for i in range(count):
        if dice.chance(0.4):
            link(f"plate{i}")
            joint(f"bolts{i}", "fixed", parent, f"plate{i}")
            parent = f"plate{i}"
        name, (low, high) = joint_name(dice, i), dice.range()
        link(f"link{i}")
        more = (
            f'<axis xyz="{dice.numbers(-2.0, 2.0)}"/><limit lower="{low!r}" upper="{high!r}" effort="9" velocity="1"/>'
        )
        inner = (low + 0.1 * dice.number(0.0, 1.0), high - 0.2 * dice.number(0.0, 1.0)) if dice.chance(0.4) else None
        if inner is not None:
            keys = f'soft_lower_limit="{inner[0]!r}" soft_upper_limit="{inner[1]!r}"'
            more += f'<safety_controller k_velocity="1" {keys}/>'
        if dice.chance():
            more += '<dynamics damping="0.3" friction="0.1"/>'
        joint(name, "revolute", parent, f"link{i}", more)
        joints, limits, soft = [*joints, name], [*limits, (low, high)], [*soft, inner]
        parent = f"link{i}"
    for finger in ("left", "right") * dice.chance():
        link(finger)
        joint(f"{finger}-slide", "prismatic", parent, finger,
              f'<axis xyz="{dice.numbers(-1.0, 1.0)}"/><limit lower="-0.05" upper="0.05" effort="1" velocity="1"/>'
              + '<mimic joint="left-slide" multiplier="-1.5" offset="0.02"/>' * (finger == "right"))  # fmt: skip
    link("hand")
    joint("hand-fixed", "fixed", parent, "hand")
    file = folder / f"random-{seed}.urdf"
    file.write_text(f'<?xml version="1.0"?>\n<robot name="random">{"".join(parts)}</robot>')
    return RandomRobot(file, joints, "hand", "hand", limits, soft)


def random_mjcf(folder: Path, seed: int) -> RandomRobot:
    """An MJCF with classes, frames, references, orientations of all kinds, fixed bodies, included files, a gripper."""
    dice = Dice(seed)
    count, in_degrees = int(dice.rng.integers(1, 8)), dice.chance()
    order = dice.one(*ORDERS)
    unit = degrees if in_degrees else float
    joints: list[str] = []
    limits: list[tuple[float, float]] = []

    def angles(count: int = 3) -> str:
        return " ".join(repr(unit(dice.number(-3.0, 3.0))) for _ in range(count))

    def turn() -> str:
        x, y = dice.rng.normal(size=(2, 3))
        return dice.one("", f'euler="{angles()}"', f'quat="{dice.numbers(-1.0, 1.0, 4)}"',
                        f'axisangle="{dice.numbers(-1.0, 1.0)} {angles(1)}"', f'zaxis="{dice.numbers(-1.0, 1.0)}"',
                        f'xyaxes="{" ".join(map(repr, [*x.tolist(), *y.tolist()]))}"')  # fmt: skip

    def pose() -> str:
        return f'pos="{dice.numbers(-0.3, 0.3)}" {turn()}'

    def weights() -> str:
        moments, axes = dice.moments()
        inertia = axes @ np.diag(moments) @ axes.T
        six = " ".join(repr(float(inertia[at])) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        mass = f'mass="{dice.number(0.1, 2.0)!r}"'
        return dice.one(
            f'<inertial pos="{dice.numbers(-0.1, 0.1)}" {mass} fullinertia="{six}"/>',
            f'<inertial {pose()} {mass} diaginertia="{" ".join(map(repr, moments.tolist()))}"/>',
            f'<geom type="capsule" fromto="{dice.numbers(-0.1, 0.1, 6)}" size="0.03"/><geom type="box" {pose()} '
            'size=".03 .04 .05" class="heavy"/>',
            f'<frame {pose()}><geom type="ellipsoid" {pose()} size=".05 .04 .03" mass="0.7"/></frame>',
        )

    def joint(i: int) -> str:
        name, (low, high) = joint_name(dice, i), dice.range()
        reference = f'ref="{unit(dice.number(-1.0, 1.0))!r}"' if dice.chance() else ""
        joints.append(name)
        limits.append((low, high))
        armature = f'armature="{dice.number(0.0, 0.1)!r}"' if dice.chance() else ""
        place = f'pos="{dice.numbers(-0.1, 0.1)}"' if dice.chance() else ""
        return (f'<joint name="{name}" axis="{dice.numbers(-2.0, 2.0)}" range="{unit(low)!r} {unit(high)!r}" '
                f'{reference} {armature} {place}/>')  # fmt: skip

    def nested(i: int) -> str:
        if i == count:
            fingers = "".join(
                f'<body name="{side}" {pose()}><joint name="{side}-slide" type="slide" axis="{dice.numbers(-1, 1)}" '
                f'range="-0.1 0.1" ref="{way}"/>{weights()}</body>'
                for side, way in (("left", "0.03"), ("right", "0"))
            )
            return fingers * with_hand + f'<site name="grip" {pose()}/>'
        fixed = dice.chance(0.3)
        body = f'<body name="link{i}" {pose()} {dice.one("", "childclass=" + chr(34) + "loose" + chr(34))}>{joint(i)}'
        body += weights() + nested(i + 1) + "</body>"
        if dice.chance(0.3):
            body = f"<frame {pose()}>{body}</frame>"
        return f'<body name="plate{i}" {pose()}>{weights()}{body}</body>' if fixed else body

    with_hand = dice.chance()
    tree = nested(0)
    equal = '<equality><joint joint1="left-slide" joint2="right-slide"/><weld body1="link0" active="false"/></equality>'
    density = f'<geom density="{dice.number(100, 2000)!r}"/>'
    heavy = '<default class="heavy"><geom mass="0.4"/></default>'
    loose = '<default class="loose"><joint armature="0.02" damping="0.1"/></default>'
    classes = f"<mujoco><default>{density}{heavy}{loose}</default></mujoco>"
    (folder / f"classes-{seed}.xml").write_text(classes)
    file = folder / f"random-{seed}.xml"
    file.write_text(
        f'<mujoco model="random"><compiler angle="{"degree" if in_degrees else "radian"}" eulerseq="{order}"/>'
        f'<include file="classes-{seed}.xml"/><option gravity="{dice.numbers(-9.0, 9.0)}"/>'
        f"<worldbody>{tree}</worldbody>{equal * with_hand}</mujoco>"
    )
    return RandomRobot(file, joints, f"link{count - 1}", "grip", limits, [None] * count)
