"""Arms of a batch against rollouts and ensembles with the same inputs, bit for bit."""

from typing import Any

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.machine import changed
from layflat.sim import Scenario, rollout
from layflat.sim.batch import Batch
from layflat.sim.ensemble import ensemble

pytestmark = pytest.mark.compiled

CYCLES, HELD = 60, 6  # control cycles of a run, and that an action holds
RECORDED = ("angle", "velocity", "pressure_a", "pressure_b", "voltage")
ACTIONS = {"demand": 0.2, "opening": 0.5, "voltage": 1.0}  # and the greatest change from its usual value
PAYLOADS = np.linspace(0.3, 1.1, 5)  # kg; not a whole number of groups of lanes


def random_actions(batch: Batch, kind: str, seed: int) -> Array:
    """Return actions that hold for some cycles each, (cycles, arms, joints)."""
    low, high = batch.action_limits
    shape = CYCLES // HELD, batch.count, len(batch.joints)
    samples = np.random.default_rng(seed).uniform(-ACTIONS[kind], ACTIONS[kind], shape)
    return np.repeat((low + high) / 2.0 + samples, HELD, axis=0)


def record(batch: Batch, actions: Array) -> dict[str, Array]:
    """Step a batch through actions; return its signals, (cycles, arms, joints), as a rollout records them."""
    signals: dict[str, list[Array]] = {name: [] for name in RECORDED}
    for action in actions:
        for name in RECORDED[:-1]:
            signals[name].append(getattr(batch, name).copy())
        batch.step(action)
        signals["voltage"].append(batch.voltage.copy())
    return {name: np.array(values) for name, values in signals.items()}


def scenario_of(batch: Batch, kind: str, actions: Array, **fields: Any) -> Scenario:
    """Return the scenario of an arm's actions, (cycles, joints): demands step, however little."""
    rates = {"demand_velocity": 0.0, "demand_acceleration": 0.0} if kind == "demand" else {}
    return Scenario(**{kind: actions, "start": 0.0, "duration": len(actions) * batch.cycle, **rates, **fields})


@pytest.mark.parametrize("kind", ACTIONS)
@pytest.mark.parametrize("name", ["paper-arm", "paper-arm-tracking"])
def test_every_arm_passes_through_the_states_of_its_rollout(name: str, kind: str) -> None:
    batch = Batch(name, len(PAYLOADS), vary={"arm.payload": PAYLOADS}, action=kind, seed=11, threads=1)
    actions = random_actions(batch, kind, 1)
    signals = record(batch, actions)
    for arm in (0, 4):
        machine = changed(batch.machine, "arm.payload", float(PAYLOADS[arm]))
        run = rollout(machine, scenario=scenario_of(batch, kind, actions[:, arm], seed=11 + arm))
        for signal in RECORDED:
            assert np.array_equal(signals[signal][:, arm], run[signal].values[:CYCLES]), (arm, signal)


@pytest.mark.parametrize(
    ("name", "precision"), [("paper-arm", "double"), ("paper-arm", "single"), ("picking-arm", "double")]
)
def test_every_arm_passes_through_the_states_of_an_ensemble(name: str, precision: str) -> None:
    batch = Batch(name, len(PAYLOADS), vary={"arm.payload": PAYLOADS}, precision=precision, seed=5, threads=1)
    actions = random_actions(batch, "demand", 2)
    actions[:] = actions[:, :1]  # an ensemble's runs may share a scenario
    signals = record(batch, actions)
    vary = {"arm.payload": PAYLOADS, "seed": 5 + np.arange(len(PAYLOADS))}
    runs = ensemble(
        name, scenario_of(batch, "demand", actions[:, 0]), vary, traces=RECORDED, precision=precision, threads=1
    )
    for signal in RECORDED:
        assert np.array_equal(signals[signal], runs[signal].values.swapaxes(0, 1)), signal
