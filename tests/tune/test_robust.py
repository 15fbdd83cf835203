import numpy as np

from layflat.description.change import value_at
from layflat.machine import load
from layflat.sim.ensemble import ensemble
from layflat.tune.robust import FLOW_VARIATION, FRICTION_VARIATION, MAX_STATIC_RATIO, robust_plant_groups, robust_plants

ARM = load("paper-arm-fast")


def test_plants_differ_as_it_is_said() -> None:
    own, other = robust_plant_groups(ARM, 256, seed=3)
    assert {of.machine.joint["small"].losses.kind for of in (own, other)} == {"elasto-slip", "bouc-wen"}
    for of in (own, other):
        assert all(len(numbers) == 128 for numbers in of.vary.values())
        brakes = of.vary["joint.small.brake.torque"] / value_at(ARM, "joint.small.brake.torque")
        assert 1.0 - FRICTION_VARIATION <= brakes.min() < 1.0 - 0.9 * FRICTION_VARIATION
        assert 1.0 + 0.9 * FRICTION_VARIATION < brakes.max() <= 1.0 + FRICTION_VARIATION
        supply = of.vary["scenario.supply"] / ARM.supply.pressure_gauge
        assert 1.0 - FLOW_VARIATION <= supply.min() < supply.max() <= 1.0 + FLOW_VARIATION
        assert of.vary["joint.large.friction.static_ratio"].max() <= MAX_STATIC_RATIO
        assert of.vary["valve.delay"].max() <= ARM.cycle


def test_they_are_the_same_for_the_same_seed_and_run() -> None:
    first, again = (robust_plant_groups(ARM, 16, seed=1) for _ in range(2))
    for one, same in zip(first, again, strict=True):
        assert all(np.array_equal(one.vary[path], same.vary[path]) for path in one.vary)
        vary = {**one.vary, "seed": np.arange(8)}
        assert np.isfinite(ensemble(one.machine, vary=vary)["ripple"].to_numpy()).all()


def test_plants_by_themselves_are_those_of_the_set() -> None:
    single = robust_plants(ARM, 6, seed=2)
    brakes = np.concatenate([of.vary["joint.small.brake.torque"] for of in robust_plant_groups(ARM, 6, seed=2)])
    supplies = np.concatenate([of.vary["scenario.supply"] for of in robust_plant_groups(ARM, 6, seed=2)])
    assert [plant.joint["small"].brake.torque for plant in single] == brakes.tolist()
    assert [plant.supply.pressure_gauge for plant in single] == supplies.tolist()
