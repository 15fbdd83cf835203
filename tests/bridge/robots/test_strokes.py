from math import radians
from pathlib import Path

import numpy as np
import pytest

from layflat.bridge.robots import ChainEnds, import_arm
from layflat.errors import InputError
from tests.bridge.robot_files import ELBOW, LOWER, SHOULDER, joint, urdf, written

BOTH = {"shoulder": (-0.5, 0.5), "elbow": (-0.5, 0.5)}
FINGER = LOWER.replace('"lower"', '"finger"') + joint("grip", "revolute", "lower", "finger", '<axis xyz="0 0 1"/>{}')


def limits(text: str) -> str:
    return ELBOW.partition("<limit")[0] + text + "</joint>"


@pytest.mark.parametrize("text", [
    '<limit effort="5" velocity="1"/>', '<limit lower="0" upper="0" effort="0"/>', '<limit lower="1" upper="-1"/>',
    '<limit lower="0" upper="1e-7"/>', '<limit lower="0.3" upper="0.3"/>',
])  # fmt: skip
def test_limits_within_which_nothing_turns_matter_only_where_they_are_used(text: str, tmp_path: Path) -> None:
    file = written(tmp_path, urdf(elbow=limits(text)))
    with pytest.raises(
        InputError, match=r"joint 'elbow' has limits from .* rad; hoses turn .* give limits of 'elbow' in `stroke`"
    ):
        import_arm(file)
    arm = import_arm(file, stroke=BOTH)
    assert [turn.mechanical for turn in arm.turning] == pytest.approx([1.0, 1.0])
    beside = written(tmp_path, urdf(FINGER.format(text)), "beside.urdf")
    assert "joints held still at zero: grip" in import_arm(beside, ends=ChainEnds(to="lower")).notes()


@pytest.mark.parametrize(
    ("soft", "middle", "works", "stops"),
    [
        ((-0.5, 0.5), 0.0, 1.0, 2.0),
        ((-0.9, 0.3), -0.3, 1.2, 1.4),  # -1 is 0.7 from the middle
        ((0.0, 2.0), 0.5, 1.0, 1.0),  # what lies beyond the limits does not count
        ((2.0, 3.0), 0.0, 1.65, 2.0),  # all of it beyond: none
        ((0.0, 0.0), 0.0, 1.65, 2.0),
        ((0.999999, 1.0), 0.0, 1.65, 2.0),
    ],
)
def test_soft_limits_are_where_a_joint_works(
    soft: tuple[float, float], middle: float, works: float, stops: float, tmp_path: Path
) -> None:
    keys = f'<safety_controller soft_lower_limit="{soft[0]}" soft_upper_limit="{soft[1]}" k_velocity="1"/>'
    arm = import_arm(written(tmp_path, urdf(elbow=ELBOW.replace("</joint>", f"{keys}</joint>"))))
    turn = arm.turning[1]
    assert (turn.middle, turn.mechanical) == pytest.approx((middle, stops))
    assert turn.works == pytest.approx(works, abs=0.01)
    told = [note for note in arm.notes() if note.startswith("stops lie as far on both sides")]
    assert bool(told) == (stops < 2.0)
    assert all(f"elbow to {np.degrees(stops):.4g} of 114.6 deg" in note for note in told)


@pytest.mark.parametrize("ref", [60, -10, 0])
def test_a_reference_shifts_the_pose_and_not_the_limits(ref: int, tmp_path: Path) -> None:
    text = f"""<mujoco><worldbody><body name="l1"><joint name="elbow" axis="0 1 0" ref="{ref}" range="30 100"/>
    <geom type="box" size=".1 .02 .02" pos=".1 0 0"/><site name="tip" pos=".2 0 0"/></body></worldbody></mujoco>"""
    file = written(tmp_path, text, "arm.xml")
    own, same = import_arm(file), import_arm(file, stroke={"elbow": (radians(30), radians(100))})
    assert own.text.toml.split("[joint")[0] == same.text.toml.split("[joint")[0]
    assert own.turning[0].middle == pytest.approx(radians(65.0))
    assert own.machine.arm.link["elbow"].rotation[1] == pytest.approx(radians(65.0 - ref))


def test_a_stroke_may_be_given_by_the_name_in_the_robot_or_here(tmp_path: Path) -> None:
    file = written(tmp_path, urdf(shoulder=SHOULDER.replace('"shoulder"', '"arm.shoulder:1"')))
    for name in ("arm.shoulder:1", "arm-shoulder-1"):
        arm = import_arm(file, stroke={name: (0.0, 1.0)}, joints=[f"{name}=paper-arm-fast:large"])
        assert list(arm.machine.joints) == ["arm-shoulder-1", "elbow"]
        assert arm.turning[0].middle == pytest.approx(0.5)
    assert "joints are called otherwise here: 'arm.shoulder:1' is 'arm-shoulder-1'" in arm.notes()
    both = {"arm.shoulder:1": (0.0, 1.0), "arm-shoulder-1": (0.0, 0.5)}
    with pytest.raises(InputError, match=r"'arm\.shoulder:1' and 'arm-shoulder-1' are one joint; give one of both"):
        import_arm(file, stroke=both)
