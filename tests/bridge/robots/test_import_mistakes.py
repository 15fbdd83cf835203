from pathlib import Path
from typing import Any

import pytest

from layflat.bridge import arm_spec, save_arm, to_mjcf, to_urdf
from layflat.bridge.robots import ChainEnds, import_arm
from layflat.errors import InputError, MachineError
from tests.bridge.robot_files import ELBOW, FLANGE, LOWER, MJCF, SHOULDER, TOOL, UPPER, joint, urdf, written

SECOND = joint("wing", "revolute", "upper", "feather", '<axis xyz="0 0 1"/><limit lower="-1" upper="1"/>')
FEATHER = LOWER.replace('"lower"', '"feather"')
LONG = [
    joint(f"j{i}", "revolute", f"l{i}", f"l{i + 1}", '<axis xyz="0 0 1"/><limit lower="-1" upper="1"/>')
    for i in range(8)
]
CHAIN = "".join(LOWER.replace('"lower"', f'"l{i}"') for i in range(9)) + "".join(LONG)
BARE = dict.fromkeys(("base", "upper", "flange", "lower", "tool0", "shoulder", "bolts", "elbow", "end"), "")


def without(text: str, part: str, instead: str = "") -> str:
    assert part in text
    return text.replace(part, instead)


WRONG: list[tuple[dict[str, str], dict[str, Any], str]] = [
    # branches and loops
    ({"more": FEATHER + SECOND}, {}, "link 'upper': carries several moving joints, such as 'elbow' and 'wing'; choose "
     "where the arm ends: `to='upper'`, or `to='tool0'`, or `to='feather'`"),
    ({"more": joint("loop", "fixed", "base", "lower")}, {}, "link 'lower': hangs on two joints, 'elbow' and 'loop': a "
     "closed chain; an arm here is an open chain; take one of both joints away"),
    ({"more": joint("back", "fixed", "tool0", "base")}, {}, "has no base: its joints go round in a circle; take the "
     "joint away that closes the loop"),
    ({"bolts": joint("bolts", "fixed", "lower", "flange")}, {}, "link 'flange': hangs on itself: a closed chain; an "
     "arm here is an open chain"),
    ({"shoulder": without(SHOULDER, "revolute", "prismatic"), "more": FEATHER + SECOND}, {}, "joint 'shoulder': is "
     "prismatic; joints of hose turn about an axis; for the arm that stands on it: `base='upper'`"),
    # joints
    ({"elbow": without(ELBOW, "revolute", "prismatic")}, {}, "joint 'elbow': is prismatic; joints of hose turn about "
     "an "
     "axis; to end the arm before it: `to='flange'`"),
    ({"shoulder": without(SHOULDER, "revolute", "floating")}, {}, "joint 'shoulder': is floating; the base of an arm "
     "stands still: `base='upper'`"),
    ({"shoulder": without(SHOULDER, "revolute", "planar")}, {}, "joint 'shoulder': is planar; the base of an arm "
     "stands "
     "still: `base='upper'`"),
    ({"elbow": without(ELBOW, "revolute", "revolut")}, {}, "joint 'elbow': has the unknown type 'revolut'; did you "
     "mean "
     "'revolute'?"),
    ({"elbow": without(ELBOW, "revolute", "continuous")}, {}, "joint 'elbow' turns without limits; hoses turn 140 "
     "deg at "
     "most: give limits of 'elbow' in `stroke`"),
    ({"elbow": without(ELBOW, '<axis xyz="0 0 2"/>')}, {}, "joint 'elbow': has no axis; give one such as <axis "
     'xyz="0 0 1"/>'),
    ({"elbow": without(ELBOW, "0 0 2", "0 0 0")}, {}, "joint 'elbow': has an axis without direction; give one such as "
     '<axis xyz="0 0 1"/>'),
    ({"elbow": without(ELBOW, "0 0 2", "0 0")}, {}, "joint 'elbow': axis: xyz is '0 0', not 3 numbers; give "
     "xyz=\"0.1 0 "
     '0.2"'),
    ({"elbow": without(ELBOW, "0 0 2", "0 0 nan")}, {}, "joint 'elbow': axis: xyz is '0 0 nan', not 3 numbers; give "
     'xyz="0.1 0 0.2"'),
    ({"elbow": without(ELBOW, 'upper="1"', 'upper="-2"')}, {}, "joint 'elbow' has limits from -1 to -2 rad; hoses "
     "turn 140 deg at most: give limits of 'elbow' in `stroke`"),
    ({"elbow": without(ELBOW, "</joint>", '<mimic joint="shoulder"/></joint>')}, {}, "joint 'elbow': mimics "
     "'shoulder'; "
     "joints here move by themselves: drop <mimic>"),
    ({"elbow": without(ELBOW, 'link="lower"', 'link="lowr"')}, {}, "joint 'elbow': has the child 'lowr', which is not "
     "there; did you mean 'lower'?"),
    (BARE | {"more": CHAIN}, {}, "has 8 joints from 'j0' to 'j7'; an arm has 7 at most; end it earlier, for example "
     "`to='l7'`"),
    ({"shoulder": without(SHOULDER, "revolute", "fixed"), "elbow": without(ELBOW, "revolute", "fixed")}, {}, "has no "
     "joint that moves; give a robot with joints that turn"),
    # masses
    ({"lower": '<link name="lower"/>'}, {}, "link 'lower': has no inertial (with tool0), and the joint 'elbow' turns "
     "it; "
     "give it mass and inertia"),
    ({"lower": without(LOWER, '<mass value="0.3"/>')}, {}, "link 'lower': has an inertial without mass; give <mass> in "
     "it"),
    ({"lower": without(LOWER, '"0.3"', '"0"')}, {}, "link 'lower': has no mass (with tool0), and the joint 'elbow' "
     "turns "
     "it; give it mass and inertia"),
    ({"lower": without(LOWER, '"0.3"', '"-0.3"')}, {}, "link 'lower': has a mass of -0.3 kg; give one above 0"),
    ({"lower": without(LOWER, '"0.0002"', '"0.02"')}, {}, "link 'lower': has principal moments of inertia 0.001, 0.001 "
     "and 0.02 kg m2; none can be greater than the other two together"),
    ({"lower": without(LOWER, '"0.0002"', '"-0.0002"')}, {}, "link 'lower': has principal moments of inertia -0.0002, "
     "0.001 and 0.001 kg m2; none can be negative"),
    ({"lower": without(without(LOWER, '"0.0002"', '"0"'), '"0.001"', '"0"')}, {}, "link 'lower': (with tool0) has the "
     "principal moment 0 kg m2; those of a body are positive; give it the inertia of a body"),
    ({"lower": without(LOWER, '"0.3"', '"0,3"')}, {}, "link 'lower': mass: value is '0,3', not a number; give "
     'value="0.1"'),
    # links and looks
    ({"more": TOOL}, {}, "link 'tool0': stands there twice; give each link a name of its own"),
    ({"upper": without(UPPER, "cylinder", "cone")}, {}, "link 'upper': has the unknown geometry 'cone'; give a box, "
     "cylinder, sphere or mesh"),
    # what stands there twice
    ({"more": '<link name="alone"/>'}, {}, "has several bases: base, alone; join them by fixed joints, or take others "
     "away"),
    ({"end": joint("elbow", "fixed", "lower", "tool0")}, {}, "joint 'elbow': stands there twice; give each joint a "
     "name of its own"),
    ({}, {"joints": ["paper-arm-fast:large", "paper-arm-fast:small"]}, "joints: there are two for all joints; give "
     "paper-arm-fast:large or paper-arm-fast:small"),
    ({}, {"joints": ["elbow=paper-arm-fast:large", "elbow=paper-arm-fast:small"]}, "joints: there are two for joint "
     "'elbow'; give paper-arm-fast:large or paper-arm-fast:small"),
    # options
    ({}, {"ends": ChainEnds(to="lowr")}, "to: there is no link 'lowr'; did you mean 'lower'?"),
    ({}, {"ends": ChainEnds(tool="base")}, "tool: 'base' is no frame that the last joint turns; frames that the "
     "last joint turns are lower, tool0"),
    ({}, {"stroke": {"elbo": (0.0, 1.0)}}, "stroke: unknown joint 'elbo'; did you mean 'elbow'?"),
    ({}, {"stroke": {"elbow": (-2.0, 2.0)}}, "stroke: 229.2 deg of joint 'elbow' are more than its hoses turn; give "
     "140 deg at most, or other `joints`"),
    ({}, {"joints": ["paper-arm"]}, "joints: 'paper-arm' names no joint; give MACHINE:JOINT, such as "
     "paper-small-joint-fast:small"),
    ({}, {"joints": ["paper-arm:huge"]}, "joints: paper-arm has no joint 'huge'; its joints are large, small"),
    ({}, {"joints": ["wrist=paper-arm:large"]}, "joints: unknown joint 'wrist'; give shoulder, elbow"),
    ({}, {"joints": ["rig-kevlar:large"]}, "joints: rig-kevlar has no valve or sensors; give a joint such as "
     "paper-small-joint-fast:small"),
    ({}, {"name": "a/b"}, "name: 'a/b' can't be a name; begin with a letter or a digit, and use letters, digits, "
     "spaces and - _ + ( )"),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "options", "expected"), WRONG)
def test_a_mistake_is_one_line(parts: dict[str, str], options: dict[str, Any], expected: str, tmp_path: Path) -> None:
    file = written(tmp_path, urdf(**parts))
    with pytest.raises(InputError) as caught:
        import_arm(file, **options)
    text = str(caught.value)
    assert "\n" not in text
    assert text.removeprefix(f"{file}: ") == expected


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.urdf", "<robot><link name='a'></robot>", "is not XML: mismatched tag at line 1, column 25; give a URDF "
         "or an MJCF"),
        ("a.urdf", "", "is not XML: no element found at line 1, column 1; give a URDF or an MJCF"),
        ("a.sdf", "<sdf/>", "is SDF, not URDF or MJCF; convert it to URDF first"),
        ("a.xml", "<sdf/>", "begins with <sdf>, not <robot> or <mujoco>; give a URDF or an MJCF"),
        ("a.urdf.xacro", "", "is XACRO, not URDF or MJCF; expand it first: xacro robot.urdf.xacro > robot.urdf"),
        ("a.urdf", '<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="b"/></robot>',
         "has macros of xacro in it; expand it first: xacro robot.urdf.xacro > robot.urdf"),
        ("a.urdf", "<robot/>", "has no links; give a URDF with links and joints"),
        ("a.xml", "<mujoco><worldbody><body><jint/></body></worldbody></mujoco>",
         "schema violation: unrecognized element Element 'jint', line 1; mend the file: MuJoCo must take it"),
        ("a.xml", "<mujoco><worldbody><body name='b'><joint/></body></worldbody></mujoco>",
         "mass and inertia of moving bodies must be larger than mjMINVAL Element name 'b', id 1, line 1; give it an "
         "inertial, or geoms with mass"),
        ("a.xml", MJCF.replace('pos=".2 0 0"', 'pos=".2 0 nan"'),
         "has numbers that are not finite; mend its numbers"),
        ("a.xml", MJCF, "body 'fore': carries several moving joints, such as 'close' and 'shut'; choose where the arm "
         "ends: `to='fore'`, or `to='finger'`, or `to='thumb'`"),
        ("a.xml", MJCF.replace('<joint name="bend"', '<joint name="also" axis="0 0 1"/><joint name="bend"'),
         "joint 'also': is one of 2 joints of the body 'fore'; joints of hose turn about an axis; to end the arm "
         "before "
         "it: `to='arm'`"),
        ("a.xml", MJCF.replace("</mujoco>", '<equality><weld name="glue" body1="fore" '
         'body2="post"/></equality></mujoco>'),
         "the equality constraint 'glue' ties fore and post: a closed chain; an arm here is an open chain; take the "
         "constraint away"),
    ],
)  # fmt: skip
def test_a_file_that_is_none_says_so(name: str, text: str, expected: str, tmp_path: Path) -> None:
    file = written(tmp_path, text, name)
    with pytest.raises(InputError) as caught:
        import_arm(file, ends=ChainEnds(to="fore" if "glue" in text or "also" in text else ""))
    assert str(caught.value) == f"{file}: {expected}"


def test_a_file_that_is_missing_or_a_folder(tmp_path: Path) -> None:
    for path in (tmp_path / "none.urdf", tmp_path):
        with pytest.raises(InputError, match="give a URDF or an MJCF"):
            import_arm(path)


def test_a_wrong_machine_of_hoses_says_so(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match="no such machine"):
        import_arm(written(tmp_path, urdf()), joints=["none:small"])


def test_a_massless_shape_is_told(tmp_path: Path) -> None:
    light = FLANGE.partition("<inertial>")[0] + '<visual><geometry><sphere radius="0.1"/></geometry></visual></link>'
    assert (
        "links that have a shape and weigh nothing: flange" in import_arm(written(tmp_path, urdf(flange=light))).notes()
    )


def test_a_point_beside_others_is_a_point_though_its_zeros_are_rounded(tmp_path: Path) -> None:
    flange = FLANGE.replace('ixx="0.0001" iyy="0.0001" izz="0.0001"', 'ixx="-2e-35" iyy="0" izz="3e-35"')
    assert flange != FLANGE
    assert len(import_arm(written(tmp_path, urdf(flange=flange))).machine.joints) == 2


@pytest.mark.parametrize("odd", [None, 1, 1.5, 1j, True, b"x", [1], {1: 2}, object(), float("nan")])
@pytest.mark.parametrize("name", ["file", "joints", "base", "to", "tool", "name", "stroke", "gravity"])
def test_what_is_of_another_type_is_one_line(name: str, odd: Any, tmp_path: Path) -> None:
    if odd is None and name in {"stroke", "gravity"}:
        return
    wrong: Any = {"ends": ChainEnds(**{name: odd})} if name in {"base", "to", "tool"} else {name: odd}
    given: Any = {"file": str(written(tmp_path, urdf()))} | wrong
    with pytest.raises(InputError) as caught:
        import_arm(**given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("odd", [None, 1, 1j, b"x", [], {}, object(), ""])
def test_what_is_no_machine_is_not_exported(odd: Any, tmp_path: Path) -> None:
    for export in (to_mjcf, to_urdf, arm_spec, lambda machine: save_arm(machine, tmp_path / "arm.xml")):
        with pytest.raises(InputError):
            export(odd)
    with pytest.raises(InputError, match="path"):
        save_arm("paper-arm", odd)
    assert list(tmp_path.iterdir()) == []
