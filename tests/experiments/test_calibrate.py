import numpy as np
import pytest

from layflat.experiments import calibrate as c
from layflat.experiments.bench import bench
from layflat.experiments.calibrated_files import replaced
from layflat.machine import load
from layflat.tune.knobs import gain_knobs, values_of

TEXT = """[a.b]
x = { value = "1 V", source = "calibrated", note = "n" }
y = { value = ["1 deg", "2 deg"], source = "calibrated" }
z = { value = 3, source = "paper" }
"""


def test_values_are_put_into_text_in_place() -> None:
    assert replaced(TEXT, "a.b.x", "2 V") == TEXT.replace("1 V", "2 V")
    assert replaced(TEXT, "a.b.y.1", "5 deg") == TEXT.replace("2 deg", "5 deg")


@pytest.mark.parametrize("path", ["a.b.z", "a.b.nowhere", "a.c.x"])
def test_only_calibrated_values_can_be_replaced(path: str) -> None:
    with pytest.raises(KeyError):
        replaced(TEXT, path, 1)


def test_losses_stand_in_the_descriptions_as_found() -> None:
    found = c.losses()
    assert load("rig-polyester").joint["small"].strap.loss_share == pytest.approx(found["strap"], rel=0.005)
    for name in ("large", "small"):
        assert load("paper-arm").joint[name].cover.loss_factor == pytest.approx(found["shell"], rel=0.005)


def test_knobs_round_trip_through_a_machine() -> None:
    arm = load("paper-arm")
    knobs = [*gain_knobs("small"), *c.VALVE_KNOBS, *c.MEMORY_KNOBS, c.WEIGHT_KNOB]
    now = values_of(arm, knobs)
    assert values_of(c.with_values(arm, knobs, now), knobs) == pytest.approx(now, rel=5e-3)


def test_a_search_improves_and_repeats_itself() -> None:
    on = bench()
    knobs = gain_knobs("small")
    start = values_of(on.arm, knobs)

    def cost(values: np.ndarray) -> float:
        return float(np.sum(np.square(values / start - 1.1)))

    one, same = (c.search(cost, knobs, start, rounds=60, seed=3) for _ in range(2))
    assert np.array_equal(one, same)
    assert cost(one) < cost(start)
