import pytest
from pydantic import ValidationError

from layflat.physics.arms.kind import ArmPart


@pytest.mark.parametrize("joints", [("small", "small"), ("large", "small", "small"), ("small", "large", "small")])
def test_a_joint_that_stands_there_twice_is_told(joints: tuple[str, ...]) -> None:
    arm = {"joints": joints, "payload": "1 kg"}
    with pytest.raises(ValidationError, match="joints names 'small' twice; name each joint once"):
        ArmPart.model_validate(arm)
