"""Arms in packages: every open chain of a robot's file that an arm here can be."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from layflat.bridge.robots.read import read_robot
from layflat.bridge.robots.robot import HINGE_JOINT, Robot
from layflat.errors import InputError
from layflat.physics.arms.kind import MAX_JOINTS

FILES: Mapping[str, tuple[str, ...]] = {
    "pybullet": (
        "pybullet_data/franka_panda/panda.urdf", "pybullet_data/kuka_iiwa/model.urdf",
        "pybullet_data/kuka_iiwa/model_vr_limits.urdf", "pybullet_data/xarm/xarm6_robot.urdf",
        "pybullet_data/xarm/xarm6_with_gripper.urdf", "pybullet_data/pendulum5.urdf", "pybullet_data/cartpole.urdf",
        "pybullet_data/laikago/laikago.urdf", "pybullet_data/quadruped/minitaur.urdf",
        "pybullet_data/racecar/racecar.urdf", "pybullet_data/a1/a1.urdf", "pybullet_data/humanoid/humanoid.urdf",
    ),
    "rtb-data": (
        "rtbdata/xacro/abb_irb140_description/urdf/irb140.urdf",
        "rtbdata/xacro/kuka_description/kuka_kr210/urdf/kr210l150.urdf",
        "rtbdata/xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf",
        "rtbdata/xacro/kuka_description/kuka_kr16/urdf/kr16_2.urdf",
        "rtbdata/xacro/kuka_description/kuka_kr120/urdf/kr120r2500pro.urdf",
        "rtbdata/xacro/unimation_puma560_description/urdf/puma560_robot.urdf",
        "rtbdata/xacro/lynxmotion_al5d_description/urdf/al5d_robot.urdf",
    ),
    "example-robot-data": tuple(
        f"cmeel.prefix/share/example-robot-data/robots/{name}"
        for name in (
            "panda_description/urdf/panda.urdf", "so_arm_description/urdf/so100.urdf",
            "so_arm_description/urdf/so101.urdf", "z1_description/urdf/z1.urdf", "b1_description/urdf/b1-z1.urdf",
            "xarm_description/urdf/xarm7.urdf", "ur_description/urdf/ur3_robot.urdf",
            "ur_description/urdf/ur5_robot.urdf", "ur_description/urdf/ur10_robot.urdf",
            "ur_description/urdf/ur3_gripper.urdf", "ur_description/urdf/ur5_gripper.urdf",
            "ur_description/urdf/ur3_joint_limited_robot.urdf", "ur_description/urdf/ur5_joint_limited_robot.urdf",
            "ur_description/urdf/ur10_joint_limited_robot.urdf", "kinova_description/robots/kinova.urdf",
            "talos_data/robots/talos_left_arm.urdf", "talos_data/robots/talos_reduced.urdf",
            "tiago_description/robots/tiago.urdf", "tiago_description/robots/tiago_dual.urdf",
            "tiago_description/robots/tiago_no_hand.urdf", "tiago_pro_description/robots/tiago_pro.urdf",
            "baxter_description/urdf/baxter.urdf", "pr2_description/urdf/pr2.urdf",
            "romeo_description/urdf/romeo.urdf", "icub_description/robots/icub_reduced.urdf",
            "hextilt_description/urdf/hextilt_flying_arm_5.urdf", "borinot_description/urdf/borinot_flying_arm_2.urdf",
            "asr_twodof_description/urdf/TwoDofs.urdf", "double_pendulum_description/urdf/double_pendulum.urdf",
            "double_pendulum_description/urdf/double_pendulum_simple.urdf",
            "double_pendulum_description/urdf/double_pendulum_continuous.urdf",
            "allegro_hand_description/urdf/allegro_right_hand.urdf", "finger_edu_description/robots/finger_edu.urdf",
            "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf", "centauro_description/urdf/centauro.urdf",
            "anymal_b_simple_description/robots/anymal-kinova.urdf", "go2_description/urdf/go2.urdf",
        )
    ),
    "robosuite": tuple(
        f"robosuite/models/assets/robots/{name}/robot.xml"
        for name in ("panda", "iiwa", "jaco", "kinova3", "sawyer", "spot_arm", "tiago", "ur5e", "xarm7", "baxter")
    ),
    "gymnasium-robotics": tuple(
        f"gymnasium_robotics/envs/{name}.xml"
        for name in ("assets/fetch/reach", "mujoco/assets/pusher", "mujoco/assets/reacher",
                     "mujoco/assets/inverted_double_pendulum", "assets/hand/reach", "assets/adroit_hand/adroit_door")
    ),
}  # fmt: skip
"""Files by the package that brings them, relative to where packages are installed."""


@dataclass(frozen=True)
class Arm:
    """An open chain of a file."""

    package: str
    name: str  # of the file, relative to where packages are
    file: Path
    to: str  # body that it ends at
    stroke: Mapping[str, tuple[float, float]]  # of joints that have no limits of their own, rad


@dataclass(frozen=True)
class Refused:
    """A file that no arm comes of, and why."""

    package: str
    name: str
    reason: str


def arms(packages: Iterable[str] = FILES) -> Iterator[Arm | Refused]:
    """Yield an arm of each file of packages: the longest open chain of hinges that begins at its base."""
    for package in packages:
        for name in FILES[package]:
            file = _installed(name)
            if file is None:
                yield Refused(package, name, "is not installed")
                continue
            try:
                robot = read_robot(file)
            except InputError as error:
                yield Refused(package, name, str(error).removeprefix(f"{file}: "))
                continue
            to = _longest(robot)
            joints = [link for link in robot.links_to(to) if link.kind == HINGE_JOINT]
            free = [link.name for link in joints if link.limits is None or link.limits[0] >= link.limits[1]]
            yield Arm(package, name, file, to, dict.fromkeys(free, (-1.0, 1.0)))


def _installed(name: str) -> Path | None:
    spec = find_spec("numpy")
    assert spec is not None
    assert spec.origin is not None
    file = Path(spec.origin).parents[1] / name
    if not file.is_file() and file.parent.parent.is_dir():
        others = sorted(file.parents[2].glob(f"*/*/{file.name}"))
        return others[0] if others else None
    return file if file.is_file() else None


def _longest(robot: Robot) -> str:
    """Return the body at the end of the chain with most hinges, up to seven, of which none is something else."""
    best, most = "", 0
    for link in robot.links:
        joints = [one for one in robot.links_to(link.child) if one.kind != "fixed"]
        plain = all(one.kind == HINGE_JOINT and one.mimic is None for one in joints)
        if plain and link.kind == HINGE_JOINT and most < len(joints) <= MAX_JOINTS:
            best, most = link.child, len(joints)
    return best
