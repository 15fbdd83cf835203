"""Joints in chains through time: against the plane's laws, against MuJoCo's step, and what holds of any of them."""

from functools import cache

import numpy as np
import pytest

from layflat.description.change import changed_all
from layflat.machine import Machine, load, parameters
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.metrics import peak_tip_acceleration, tip_settling
from tests.physics.arms.chain.chains import as_chain, random_arm

pytestmark = pytest.mark.compiled

SWING = [("0 s", (0.0, 0.0)), ("0.1 s", (0.08, -0.06)), ("1 s", (-0.06, 0.07)), ("2 s", (0.05, -0.05))]


@cache
def arm_of(n: int) -> Machine:
    return random_arm(n, seed=n, single=("j1",) if n == 3 else ())


def test_the_papers_arm_as_a_chain_moves_as_it_does_in_its_plane() -> None:
    runs = [rollout(m, opening=SWING, brake=0.0, duration="4 s") for m in (load("paper-arm-fast"), as_chain())]
    planar, chained = (np.degrees(run["angle"].to_numpy()) for run in runs)
    assert np.ptp(planar, axis=0).min() > 30.0
    assert np.abs(planar - chained).max() < 1e-9
    assert list(runs[1]["axis"].values) == ["x", "y", "z"]


@pytest.mark.parametrize("n", [1, 3, 7])
def test_brakes_hold_any_number_of_joints_where_they_are(n: int) -> None:
    draw = np.random.default_rng(n)
    start = draw.uniform(-0.8, 0.8, n)
    names = list(arm_of(n).joints)
    at = {name: f"{angle!r} rad" for name, angle in zip(names, start.tolist(), strict=True)}
    firm = {f"joint.{name}.brake.torque": 20.0 * joint.brake.torque for name, joint in arm_of(n).joints.items()}
    run = rollout(changed_all(arm_of(n), firm), start=at, opening=0.0, duration="2 s")
    assert np.ptp(run["angle"].to_numpy(), axis=0).max() == 0.0


def test_arms_begin_at_rest_against_gravity_and_springs() -> None:
    """Without brakes the air alone holds the arm until hoses lose some; else it would turn by a tenth of a degree."""
    run = rollout(arm_of(3), opening=0.0, brake=0.0, noise=False, duration="5 ms")
    assert np.abs(run["angle"].to_numpy()).max() < np.radians(1e-3)
    held = run["pressure_a"] - run["pressure_b"]
    assert np.abs(held.to_numpy()[0]).min() > 100.0
    outside = arm_of(3).supply.ambient_pressure
    assert run["pressure_b"].sel(joint="j1").to_numpy() == pytest.approx(outside, rel=1e-12)


def energy(machine: Machine, q: np.ndarray, v: np.ndarray) -> float:
    """Of the motion, J."""
    mass, _ = parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, q.tolist())
    return float(0.5 * v @ mass @ v)


def test_the_books_of_a_chain_are_closed() -> None:
    """Kinetic energy is what air, gravity and losses leave of their works: to a millionth, and by second order."""
    misses = []
    for step in ("0.25 ms", "0.125 ms"):
        run = rollout(arm_of(4), opening=0.02, brake=0.0, duration="0.5 s", step=step)
        gained = run["gas_work"] + run["load_work"] - run["hose_work"] - run["brake_heat"] - run["damping_heat"]
        moves = [energy(arm_of(4), q, v) for q, v in zip(run["angle"].values, run["velocity"].values, strict=True)]
        assert max(moves) > 1e-3
        misses.append(np.abs(gained.sum("joint").values - moves).max() / np.abs(run["gas_work"].sum("joint")).max())
    assert misses[0] < 1e-6
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.1)


def test_order_of_convergence() -> None:
    steps = [1.0, 0.5, 0.25]
    runs = [
        rollout(arm_of(4), opening=0.02, brake=0.0, duration="0.4 s", step=f"{step / 4} ms")["angle"].to_numpy()
        for step in (*steps, 1 / 16)
    ]
    errors = [np.sqrt(np.mean((run - runs[-1]) ** 2)) for run in runs[:-1]]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.8


def test_runs_of_an_ensemble_are_rollouts() -> None:
    machine, goal = arm_of(3), (0.2, -0.3, 0.1)
    case = Scenario(demand=[(0.0, (0.0, 0.0, 0.0)), (0.1, goal)], duration="0.6 s", noise=True)
    payloads = np.array([0.0, 0.2, 0.5])
    many = ensemble(machine, case, {"scenario.payload": payloads, "seed": np.arange(3)}, traces=["angle"])
    for i, payload in enumerate(payloads.tolist()):
        run = rollout(machine, scenario=case, payload=payload, seed=i)
        assert np.array_equal(run.angle[:-1], many.angle[i])
        assert float(many.peak_acceleration[i]) == pytest.approx(peak_tip_acceleration(run), rel=1e-9)
        band = 0.5 * float(np.linalg.norm(run.tip[-1] - run.tip[0]))
        coarse = ensemble(machine, case, {"scenario.payload": payloads[i : i + 1], "seed": [i]}, tip_band=band)
        settled = tip_settling(run, 0.1, 0.6 - 1e-6, band)
        assert float(coarse.tip_settling[0, -1]) == pytest.approx(settled, abs=1e-9)
