"""Batches: resets, saved states, threads, inputs in flight, divergence, and wrong arguments."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.sim.batch import Batch

pytestmark = pytest.mark.compiled

COUNT = 300  # enough for two threads, and not a whole number of groups of lanes
ARM = "paper-arm"


def random_actions(batch: Batch, cycles: int, seed: int) -> Array:
    """Return random demands, (cycles, arms, joints), rad."""
    return np.random.default_rng(seed).uniform(-0.3, 0.3, (cycles, batch.count, len(batch.joints)))


def signals_of(batch: Batch) -> dict[str, Array]:
    """Return copies of all live arrays."""
    names = ("angle", "velocity", "pressure_a", "pressure_b", "voltage", "sensed_angle", "sensed_pressure", "tip")
    live = {name: getattr(batch, name) for name in (*names, "valve_opening", "time", "diverged")}
    inputs = {f"input {name}": array for name, array in batch.inputs.items()}
    return {name: array.copy() for name, array in {**live, **inputs, **batch.report}.items()}


def assert_same(one: dict[str, Array], other: dict[str, Array], arms: Any = slice(None), others: Any = None) -> None:
    """Compare the signals of arms of two batches to the bit."""
    for name, array in one.items():
        match = other[name][arms if others is None else others]
        assert np.array_equal(array[arms], match, equal_nan=True), name


@pytest.mark.parametrize("precision", ["double", "single"])
def test_resets_states_and_threads_leave_the_bits(precision: str) -> None:
    payloads = np.linspace(0.0, 2.0, COUNT)
    options: dict[str, Any] = {"vary": {"arm.payload": payloads}, "precision": precision, "seed": 3}
    with Batch(ARM, COUNT, threads=1, **options) as one, Batch(ARM, COUNT, threads=2, **options) as two:
        actions = random_actions(one, 40, 7)
        mask = np.random.default_rng(8).random(COUNT) < 0.3
        saved = None
        for k, action in enumerate(actions):
            if k == 15:
                one.reset(mask, vary={"arm.payload": np.full(mask.sum(), 0.7)}, start=0.1, seed=99)
                two.reset(np.flatnonzero(mask), vary={"arm.payload": np.full(mask.sum(), 0.7)}, start=0.1, seed=99)
            if k == 25:
                saved = pickle.loads(pickle.dumps(one.state()))
            one.step(action)
            two.step(action)
        end = signals_of(one)
        assert_same(end, signals_of(two))
        assert saved is not None
        two.set_state(saved)
        for action in actions[25:]:
            two.step(action)
        assert_same(end, signals_of(two))
        # Arms that were reset are those of a batch that begins so.
        with Batch(ARM, int(mask.sum()), vary={"arm.payload": np.full(mask.sum(), 0.7)}, start=0.1, seed=99,
                   precision=precision) as fresh:  # fmt: skip
            for action in actions[15:]:
                fresh.step(action[mask])
            assert_same(signals_of(fresh), end, slice(None), mask)


def test_branches_of_one_arm_go_their_own_ways_and_meet_where_actions_agree() -> None:
    with Batch(ARM, 1) as trunk, Batch(ARM, 5, seed=50) as branches:
        for _ in range(20):
            trunk.step([[0.2, -0.1]])
        branches.set_state(trunk.state().take([0] * 5))
        actions = np.array([[0.3, 0.0], [0.2, -0.1], [0.0, 0.0], [0.2, -0.1], [-0.3, 0.1]])
        for _ in range(20):
            trunk.step()
            branches.step(actions)
        for arm in (1, 3):
            assert_same(signals_of(trunk), signals_of(branches), [0], [arm])
        assert len(np.unique(branches.angle[:, 0])) == 4


def test_saved_arms_at_rest_begin_with_new_noise() -> None:
    payloads = np.linspace(0.0, 2.0, 10)
    with Batch(ARM, 10, vary={"arm.payload": payloads}) as batch, Batch(ARM, 2, seed=[70, 4]) as fresh:
        pool = batch.state()
        batch.step(random_actions(batch, 1, 3)[0], cycles=30)
        batch.set_state(pool.take([3, 8]), [1, 6], seed=[70, 4])
        fresh.reset(vary={"arm.payload": payloads[[3, 8]]}, seed=[70, 4])
        action = np.full((10, 2), 0.2)
        batch.step(action, cycles=20)
        fresh.step(action[:2], cycles=20)
        assert_same(signals_of(fresh), signals_of(batch), [0, 1], [1, 6])


def test_several_cycles_in_a_call_are_as_many_calls() -> None:
    with Batch(ARM, 40, threads=1) as one, Batch(ARM, 40, threads=1) as other:
        action = random_actions(one, 1, 2)[0]
        one.step(action, cycles=25)
        for _ in range(25):
            other.step(action)
        assert_same(signals_of(one), signals_of(other))
        assert np.allclose(one.time, 25 * one.cycle)


def test_arrays_are_the_kernels_memory() -> None:
    with Batch(ARM, 9) as batch:
        angle, tip = batch.angle, batch.tip
        before = angle.copy()
        batch.step(np.full((9, 2), 0.3), cycles=40)
        assert angle is batch.angle
        assert (angle != before).all()
        assert tip.shape == (9, 3)
        with pytest.raises(ValueError, match="read-only"):
            angle[0, 0] = 1.0
        assert {"angle", "tip", "payload", "averaged_velocity"} <= set(batch.units)
        assert batch.units["action"] == ("rad", "demanded angle")


def test_payload_and_load_change_in_flight() -> None:
    with Batch(ARM, 2, noise=False) as batch:
        batch.step(np.zeros((2, 2)), cycles=20)
        assert np.array_equal(batch.angle[0], batch.angle[1])
        batch.inputs["payload"][1] = 3.0
        batch.inputs["load"][1] = 5.0
        batch.step(cycles=100)
        assert abs(batch.angle[1] - batch.angle[0]).max() > 1e-3


def test_a_regulator_brings_the_differential_pressure() -> None:
    with Batch(ARM, 3, action="pressure", noise=False) as batch:
        demand = np.array([[0.5e5, -0.5e5], [1.0e5, 0.0], [0.0, 1.0e5]])
        batch.step(demand, cycles=400)  # until the joints rest at their stops
        assert np.allclose(batch.pressure_a - batch.pressure_b, demand, atol=0.1e5)


def test_an_arm_that_diverges_is_held_and_the_others_go_on() -> None:
    with Batch(ARM, 20, seed=1) as batch, Batch(ARM, 20, seed=1) as sound:
        action = random_actions(batch, 1, 4)[0]
        for each in (batch, sound):
            each.step(action, cycles=10)
        batch.inputs["load"][7] = 1e30
        batch.step(cycles=10)
        sound.step(cycles=10)
        assert batch.diverged.tolist() == [arm == 7 for arm in range(20)]
        held = signals_of(batch)
        assert all(np.isfinite(held[name][7]).all() for name in ("angle", "velocity", "pressure_a", "tip", "voltage"))
        batch.step(cycles=5)
        assert np.array_equal(batch.angle[7], held["angle"][7])
        assert batch.time[7] == held["time"][7]
        sound.step(cycles=5)
        others = np.arange(20) != 7
        assert_same(signals_of(batch), signals_of(sound), others)
        batch.reset([7])
        assert not batch.diverged.any()
        batch.step(cycles=5)
        assert batch.time[7] == pytest.approx(5 * batch.cycle)


def test_new_machines_stay_with_the_arms_that_got_them() -> None:
    """A reset without `vary` keeps each arm's machine."""
    with Batch(ARM, 4, noise=False, vary={"arm.payload": [0.0, 1.0, 2.0, 3.0]}) as batch:
        batch.reset([1], vary={"joint.small.brake.torque": ["1 N m"]})
        batch.reset(vary={"scenario.supply": np.full(4, 3e5)})
        batch.step(np.full((4, 2), 0.3), cycles=60)
        for arm, (payload, brake) in enumerate([(0.0, None), (1.0, 1.0), (2.0, None), (3.0, None)]):
            machine = changed(load(ARM), "arm.payload", payload)
            if brake is not None:
                machine = changed(machine, "joint.small.brake.torque", brake)
            with Batch(machine, 1, noise=False, vary={"scenario.supply": [3e5]}) as own:
                own.step([[0.3, 0.3]], cycles=60)
                assert np.array_equal(own.angle[0], batch.angle[arm])


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (np.zeros((3, 2)), "shape"),
        (np.zeros(2), "shape"),
        ([["a", "b"]] * 2, "no numbers"),
        ([[0.0, np.nan], [0.0, 0.0]], "arm 0, joint 'small'|arm 0, joint 'large'"),
        ([[0.0, 0.0], [9.0, 0.0]], "9 rad of arm 1, .* give -.* to .* rad, or clip=True"),
        (np.full((2, 2), np.inf), "no number"),
        (np.zeros((2, 2), complex), "no numbers"),
    ],
)
def test_wrong_actions_change_nothing(action: Any, message: str) -> None:
    with Batch(ARM, 2) as batch:
        before = signals_of(batch)
        with pytest.raises(InputError, match=message):
            batch.step(action)
        assert_same(before, signals_of(batch))


def test_actions_beyond_their_range_are_clipped_where_told_to() -> None:
    with Batch(ARM, 2, clip=True, action="opening") as batch:
        batch.step([[7.0, -7.0], [0.0, 0.5]])
        assert batch.inputs["opening"].tolist() == [[1.0, -1.0], [0.0, 0.5]]
        with pytest.raises(InputError, match="no number"):
            batch.step([[np.nan, 0.0], [0.0, 0.0]])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 0}, "count"),
        ({"count": 10**8}, "give .* or fewer"),
        ({"action": "force"}, "use opening, voltage, demand, pressure"),
        ({"precision": "half"}, "precision"),
        ({"vary": {"arm.payload": [1.0]}}, "different numbers"),
        ({"vary": {"arm.paylaod": [1.0, 2.0]}}, "payload"),
        ({"start": np.zeros((3, 2))}, "shape"),
        ({"start": 3.0}, "start"),
        ({"seed": -1}, "seed"),
        ({"seed": [1, 2, 3]}, "one per arm"),
        ({"seed": 0.5}, "one per arm"),
        ({"vary": {"seed": [1, 2]}}, "argument seed"),
        ({"vary": {"scenario": [0, 0]}}, "inputs"),
        ({"threads": 0}, "threads"),
        ({"machine": "no-such"}, "no-such"),
        ({"clip": "yes"}, "clip"),
        ({"controller": "picking-arm"}, "joints"),
    ],
)
def test_wrong_arguments(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Batch(**{"machine": ARM, "count": 2, **options})


def test_wrong_arms_and_states() -> None:
    with Batch(ARM, 3) as batch, Batch("paper-arm-fast", 3) as other:
        for arms, message in (([3], "3 is no arm"), ([-1], "-1 is no arm"), ([True], "shape"), ([0.5], "no numbers")):
            with pytest.raises(InputError, match=message):
                batch.reset(arms)
        with pytest.raises(InputError, match="another kind"):
            batch.set_state(other.state())
        with pytest.raises(InputError, match=r"saved by layflat 0\.0"):
            batch.set_state(replace(batch.state(), version="0.0"))
        with pytest.raises(InputError, match="holds 3 arms, for 1"):
            batch.set_state(batch.state(), [1])
        with pytest.raises(InputError, match="cycles"):
            batch.step(cycles=0)
        batch.reset([])
        batch.close()
        batch.close()
        for call in (batch.step, batch.reset):
            with pytest.raises(InputError, match="is closed"):
                call()
        assert batch.angle.shape == (3, 2)
