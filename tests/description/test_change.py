import pytest

from layflat.errors import InputError
from layflat.machine import changed, load

ARM = load("paper-arm")


def test_one_value_is_replaced_and_the_rest_stays() -> None:
    other = changed(ARM, "joint.small.losses.deflections.0", 0.5)
    assert other.joint["small"].losses.deflections[0] == 0.5
    assert changed(other, "joint.small.losses.deflections.0", ARM.joint["small"].losses.deflections[0]) == ARM


@pytest.mark.parametrize("path", ["joint.wrist.brake.torque", "joint.small.brake.torqe", "arm.joints.7", "nothing"])
def test_a_path_that_is_not_there(path: str) -> None:
    with pytest.raises(InputError, match="is not there"):
        changed(ARM, path, 1.0)
