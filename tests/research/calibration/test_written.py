import pytest

from layflat.machine import load
from research.calibration.written import loss_shares, replace_value

TEXT = """[a.b]
x = { value = "1 V", source = "calibrated", note = "n" }
y = { value = ["1 deg", "2 deg"], source = "calibrated" }
z = { value = 3, source = "paper" }
"""


def test_values_are_put_into_text_in_place() -> None:
    assert replace_value(TEXT, "a.b.x", "2 V") == TEXT.replace("1 V", "2 V")
    assert replace_value(TEXT, "a.b.y.1", "5 deg") == TEXT.replace("2 deg", "5 deg")


@pytest.mark.parametrize("path", ["a.b.z", "a.b.nowhere", "a.c.x"])
def test_only_calibrated_values_can_be_replaced(path: str) -> None:
    with pytest.raises(KeyError):
        replace_value(TEXT, path, 1)


def test_losses_stand_in_the_descriptions_as_found() -> None:
    found = loss_shares()
    assert load("rig-polyester").joint["small"].strap.loss_fraction == pytest.approx(found["strap"], rel=0.005)
    for name in ("large", "small"):
        assert load("paper-arm").joint[name].cover.loss_factor == pytest.approx(found["shell"], rel=0.005)
