import numpy as np
import pytest

from layflat.experiments import calibrate as c
from layflat.experiments.bench import bench
from layflat.experiments.calibrate import replaced
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


TIME = np.arange(0.0, 4.0, 0.005)


def cost(error: np.ndarray) -> float:
    """Of errors (deg) over the three seconds after the step."""
    return c.verdict(np.radians(error[:600]), 0.005)


def test_a_calibrated_step_costs_its_time_its_overshoot_and_what_remains() -> None:
    after = TIME
    quick = cost(np.where(after < 0.3, -40.0, 0.0))
    late = cost(np.where(after < 1.6, -40.0, 0.0))
    assert quick == pytest.approx(c.SOON), "haste is worth nothing"
    assert late == pytest.approx(1.6, abs=0.011)
    beyond = cost(np.where(after < 0.3, -40.0, np.where(after < 0.5, 6.0, 0.0)))
    assert beyond == pytest.approx(c.SOON + c.OVERSHOOT * 5.0)
    assert cost(np.where(after < 0.3, -40.0, 0.5)) == pytest.approx(3.0 + c.OFF * 0.5, abs=0.02)
    assert cost(np.where(after < 0.3, -40.0, 20.0)) == pytest.approx(3.0 + c.OVERSHOOT * 19.0 + 5.0, abs=0.02)


def test_a_knob_of_weights_keeps_their_sum() -> None:
    machine = c.with_values(load("paper-arm"), [c.WEIGHT_KNOB], [0.3])
    for joint in machine.joints.values():
        assert joint.losses.weights == pytest.approx((0.3, 0.35, 0.35))
    assert c.written([c.WEIGHT_KNOB], np.array([0.3]))["joint.small.losses.weights"] == [0.3, 0.35, 0.35]


def test_knobs_of_joints_that_are_not_there_are_passed_over() -> None:
    earlier = load("earlier-actuator")
    earlier = earlier.model_copy(update={"joint": {"small": earlier.joint["small"]}})
    values = [float(value) for value in values_of(load("paper-arm"), gain_knobs("large"))]
    assert c.with_values(earlier, gain_knobs("large"), values) == earlier
