from pathlib import Path

import pytest

from layflat.bridge.robots import import_arm
from layflat.errors import InputError
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
    return float(import_arm(written(folder, text), to="lower").machine.arm.link["elbow"].centre[1])


def test_what_mimics_is_held_where_it_then_is(tmp_path: Path) -> None:
    still = centre(urdf(fingers('<mimic joint="open" multiplier="2"/>')), tmp_path)
    moved = centre(urdf(fingers('<mimic joint="open" multiplier="2" offset="0.03"/>')), tmp_path)
    assert moved - still == pytest.approx(0.03 / 3.0)  # one of three bodies of one mass


def test_notes_say_where_joints_are_held(tmp_path: Path) -> None:
    text = urdf(fingers('<mimic joint="elbow" offset="0.03"/>', "0.01"))
    notes = import_arm(written(tmp_path, text), to="lower").notes()
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
    assert "joints held still: open at 0.02 m" in import_arm(file, to="hand").notes()


@pytest.mark.parametrize("equality", [
    '<joint joint1="open" joint2="bend"/>', '<joint joint1="bend"/>', '<weld body1="hand" body2="post"/>',
    '<tendon tendon1="both"/>', '<connect body1="left" body2="post" anchor="0 0 0"/>',
])  # fmt: skip
def test_constraints_that_act_on_the_arm_close_it(equality: str, tmp_path: Path) -> None:
    file = written(tmp_path, GRIPPER.format(equality=equality, tendon="bend"), "robot.xml")
    with pytest.raises(InputError, match=r"the equality constraint .* a closed chain; an arm here is an open chain"):
        import_arm(file, to="hand")


@pytest.mark.parametrize("axis", ["0 0 0", "0 1e200 0"])
def test_a_slide_of_any_axis_is_held(axis: str, tmp_path: Path) -> None:
    text = fingers('<mimic joint="open" offset="0.03"/>').replace('"0 1 0"', f'"{axis}"')
    moved = centre(urdf(text), tmp_path) - centre(urdf(text.replace('"0.03"', '"0"')), tmp_path)
    assert moved == pytest.approx(0.0 if axis == "0 0 0" else 0.01)
