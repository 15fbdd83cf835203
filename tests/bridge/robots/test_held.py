"""Joints that are held still, and arms that stand on a body above a robot's base.

Their mass matrix, gravity and tip are MuJoCo's with the rest still.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.bridge.robots import ChainEnds, import_arm
from layflat.errors import InputError
from layflat.machine import parameters
from layflat.physics.arms import ARM_KINDS
from tests.bridge.robot_files import LOWER, joint, urdf, written

LEFT, RIGHT = (LOWER.replace('"lower"', f'"{side}"') for side in ("left", "right"))
SLIDE = '<axis xyz="0 1 0"/><limit lower="{}" upper="0.1"/>'


def fingers(mimic: str, lower: str = "0") -> str:
    slide = SLIDE.format(lower)
    return (
        LEFT
        + RIGHT
        + joint("open", "prismatic", "lower", "left", slide)
        + joint("follow", "prismatic", "lower", "right", slide + mimic)
    )


def centre(text: str, folder: Path) -> float:
    return float(import_arm(written(folder, text), ends=ChainEnds(to="lower")).machine.arm.link["elbow"].centre[1])


def test_what_mimics_is_held_where_it_then_is(tmp_path: Path) -> None:
    still = centre(urdf(fingers('<mimic joint="open" multiplier="2"/>')), tmp_path)
    moved = centre(urdf(fingers('<mimic joint="open" multiplier="2" offset="0.03"/>')), tmp_path)
    assert moved - still == pytest.approx(0.03 / 3.0)  # one of three bodies of one mass


def test_notes_say_where_joints_are_held(tmp_path: Path) -> None:
    text = urdf(fingers('<mimic joint="elbow" offset="0.03"/>', "0.01"))
    notes = import_arm(written(tmp_path, text), ends=ChainEnds(to="lower")).notes()
    assert notes[:4] == [
        "joints held still at zero: open",
        "joints held still: follow at 0.03 m",
        "their own limits do not let them be there: open (0.01 to 0.1 m)",
        "in the robot follow follows elbow; here it is held still, and its mass with it",
    ]


GRIPPER = """<mujoco><worldbody><body name="arm"><joint name="bend" axis="0 1 0" range="-60 60"/>
<geom size=".1"/><body name="hand"><geom size=".1"/>
<body name="left"><joint name="open" type="slide" axis="0 1 0" range="0 .1" ref="0.02"/><geom size=".01"/></body>
<body name="right"><joint name="shut" type="slide" axis="0 1 0" range="0 .1"/><geom size=".01"/></body></body></body>
<body name="post"/></worldbody>
<tendon><fixed name="both"><joint joint="open" coef="1"/><joint joint="{tendon}" coef="1"/></fixed></tendon>
<equality>{equality}</equality></mujoco>"""


@pytest.mark.parametrize("equality", [
    '<joint joint1="open" joint2="shut"/>', '<connect body1="left" body2="right" anchor="0 0 0"/>',
    '<tendon tendon1="both"/>', '<weld body1="hand" body2="post" active="false"/>',
    '<joint joint1="bend" active="false"/>',
])  # fmt: skip
def test_constraints_between_what_is_held_or_that_do_not_act_close_no_chain(equality: str, tmp_path: Path) -> None:
    file = written(tmp_path, GRIPPER.format(equality=equality, tendon="shut"), "robot.xml")
    assert "joints held still: open at 0.02 m" in import_arm(file, ends=ChainEnds(to="hand")).notes()


@pytest.mark.parametrize("equality", [
    '<joint joint1="open" joint2="bend"/>', '<joint joint1="bend"/>', '<weld body1="hand" body2="post"/>',
    '<tendon tendon1="both"/>', '<connect body1="left" body2="post" anchor="0 0 0"/>',
])  # fmt: skip
def test_constraints_that_act_on_the_arm_close_it(equality: str, tmp_path: Path) -> None:
    file = written(tmp_path, GRIPPER.format(equality=equality, tendon="bend"), "robot.xml")
    with pytest.raises(InputError, match=r"the equality constraint .* a closed chain; an arm here is an open chain"):
        import_arm(file, ends=ChainEnds(to="hand"))


@pytest.mark.parametrize("axis", ["0 0 0", "0 1e200 0"])
def test_a_slide_of_any_axis_is_held(axis: str, tmp_path: Path) -> None:
    text = fingers('<mimic joint="open" offset="0.03"/>').replace('"0 1 0"', f'"{axis}"')
    moved = centre(urdf(text), tmp_path) - centre(urdf(text.replace('"0.03"', '"0"')), tmp_path)
    assert moved == pytest.approx(0.0 if axis == "0 0 0" else 0.01)


mujoco: Any = pytest.importorskip("mujoco")

INERTIAL = '<inertial pos="0.1 0 0.02" mass="0.5" diaginertia="0.001 0.002 0.0025"/>'
LIFT = '<joint name="lift" type="slide" axis="0 0 1" range="0 0.5"/>'
LIFTED = f"""<mujoco model="lifted"><option gravity="0.5 -1 -9"/><worldbody>
<body name="column" pos="0 0.1 0.5" euler="20 -30 40">{{joint}}{INERTIAL}
  <body name="upper" pos="0 0.2 0.1" euler="0 0 30"><joint name="shoulder" axis="0 1 0.2" range="-60 60"/>{INERTIAL}
    <body name="fore" pos="0.3 0 0"><joint name="elbow" axis="0 1 0" range="-60 60"/>{INERTIAL}
      <site name="tip" pos="0.2 0 0.01"/></body></body></body></worldbody></mujoco>"""

LINK = """<link name="{0}"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
<inertia ixx="0.001" iyy="0.002" izz="0.0025" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="{4}"/>
<origin xyz="0.3 0 0.1" rpy="0.2 0.3 -0.4"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>"""
URDF = (
    '<robot name="lifted"><link name="base"/>'
    + "".join(LINK.format(name) for name in ("column", "upper", "fore"))
    + JOINT.format("lift", "{kind}", "base", "column", "0 0 1")
    + JOINT.format("shoulder", "revolute", "column", "upper", "0 1 0")
    + JOINT.format("elbow", "revolute", "upper", "fore", "0 1 0.3")
    + "</robot>"
)


@pytest.mark.parametrize("joint", [LIFT, "<freejoint/>", '<joint name="turn" axis="1 0 0" range="-9 9"/>', ""])
def test_gravity_and_mass_are_those_of_the_arm_alone(joint: str, tmp_path: Path) -> None:
    file = written(tmp_path, LIFTED.format(joint=joint), "arm.xml")
    arm = import_arm(file, ends=ChainEnds(base="column"))
    assert list(arm.machine.joints) == ["shoulder", "elbow"]
    assert arm.machine.arm.gravity != (0.5, -1.0, -9.0)
    assert any("held still" in note for note in arm.notes()) == bool(joint)
    model = mujoco.MjModel.from_xml_path(str(file))
    compare(arm, model, "tip")


@pytest.mark.parametrize("kind", ["prismatic", "floating", "revolute", "fixed"])
def test_of_urdf_as_of_mjcf(kind: str, tmp_path: Path) -> None:
    file = written(tmp_path, URDF.format(kind=kind), "arm.urdf")
    arm = import_arm(file, ends=ChainEnds(base="column", tool="fore"))
    model = mujoco.MjModel.from_xml_path(str(file)) if kind != "floating" else None
    if model is not None:
        model.opt.gravity[:] = 0.0, 0.0, -9.80665
        compare(arm, model, "fore")


def compare(arm: Any, model: Any, tip: str) -> None:
    data = mujoco.MjData(model)
    own = [int(model.joint(name).dofadr[0]) for name in ("shoulder", "elbow")]
    angles = np.array([0.4, -0.6])
    for name, angle in zip(("shoulder", "elbow"), angles, strict=True):
        data.joint(name).qpos = angle
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    mass, pull = parameters.mass_and_pull(parameters.arm(arm.machine), 0.0, angles.tolist())
    assert np.allclose(mass, full[np.ix_(own, own)], rtol=1e-10, atol=1e-14)
    assert np.allclose(pull, -data.qfrc_bias[own], rtol=1e-10, atol=1e-12)
    bodies: Any = ARM_KINDS.named("chain").bodies
    place = bodies(arm.machine.arm, list(arm.machine.joints.values())).poses(angles)[-1][1]
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "column") < 0:  # of a URDF MuJoCo merges what stands still
        return
    column = data.body("column")
    there = (data.site(tip) if model.nsite else data.body(tip)).xpos
    assert np.allclose(place, column.xmat.reshape(3, 3).T @ (there - column.xpos), atol=1e-12)


@pytest.mark.parametrize(("joint", "word"), [(LIFT, "slide"), ("<freejoint/>", "floating")])
def test_the_advice_to_leave_out_the_lift_works(joint: str, word: str, tmp_path: Path) -> None:
    file = written(tmp_path, LIFTED.format(joint=joint), "arm.xml")
    with pytest.raises(InputError, match="`base='column'`") as caught:
        import_arm(file)
    assert "prismatic" in str(caught.value) or word in str(caught.value)
    with pytest.raises(InputError, match="base: there is no body 'colum'; did you mean 'column'"):
        import_arm(file, ends=ChainEnds(base="colum"))


def test_a_flag_that_switches_gravity_off_counts(tmp_path: Path) -> None:
    text = LIFTED.format(joint="").replace('-9"/>', '-9"><flag gravity="disable"/></option>')
    arm = import_arm(written(tmp_path, text, "arm.xml"))
    assert tuple(arm.machine.arm.gravity) == (0.0, 0.0, 0.0)


def test_an_orientation_that_readers_skip_is_refused_with_the_angles_that_are_the_same(tmp_path: Path) -> None:
    text = URDF.format(kind="fixed")
    half = np.array([0.0, 0.0, np.sin(0.35), np.cos(0.35)])
    asked = text.replace('rpy="0.2 0.3 -0.4"', f'quat_xyzw="{" ".join(map(str, half))}"')
    with pytest.raises(InputError, match=r'most readers skip without a word; give rpy="0 0 0.7" in its place'):
        import_arm(written(tmp_path, asked, "arm.urdf"))
