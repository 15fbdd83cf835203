"""A sized arm does its task in simulation, with the tracking law, which is not told what it carries."""

import numpy as np
import pytest

from layflat.design.arm import read_task
from layflat.design.arm.sizing import SizedArm, size_arm
from layflat.motion.dynamics import rigid_torques
from layflat.motion.kinematics import tip_position
from layflat.motion.trajectory import States, quintic
from layflat.sim import rollout

pytestmark = pytest.mark.compiled

CLOSE = 5e-3  # of the tip to its goal, m
BEFORE, AFTER = 0.3, 0.5  # rest before and after a move, s
VOLUME = {"low": ["400 mm", "-350 mm", "-200 mm"], "high": ["700 mm", "350 mm", "500 mm"]}


@pytest.fixture(scope="module")
def arm() -> SizedArm:
    """A light arm: its joints hold their load with most of what they can."""
    return size_arm(read_task("picking-arm", time="1 s", volume=VOLUME))


def distances(arm: SizedArm, move: int, payload: float) -> tuple[np.ndarray, np.ndarray]:
    """Times since a move began (s), and distances of the tip from where it ends (m)."""
    machine, moves = arm.machine, arm.moves
    time, start, end = float(moves.times[move]), moves.starts[move], moves.ends[move]
    t = np.arange(0.0, BEFORE + time + AFTER, machine.cycle)
    (share, rate, change), way = quintic(np.maximum(t - BEFORE, 0.0)[:, None] / time), end - start
    run = rollout(
        machine,
        start + share * way,
        demand_velocity=rate / time * way,
        demand_acceleration=change / time**2 * way,
        duration=len(t) * machine.cycle,
        payload=payload,
        controller=machine,
        start=start.tolist(),
    )
    away = np.linalg.norm(run["tip"].to_numpy() - tip_position(machine, end[None])[0], axis=1)
    return run["time"].to_numpy() - BEFORE, away


@pytest.mark.parametrize("payload", [1.0, 0.5])
def test_moves_take_the_tasks_time(arm: SizedArm, payload: float) -> None:
    asked = np.abs(rigid_torques(arm.machine, arm.moves.states, payload))
    shares = arm.moves.by_move(asked / [part.torque for part in arm.parts]).max(axis=(1, 2))
    hardest = np.argsort(shares)[-3:]
    for move in [0, *hardest.tolist()]:
        time, away = distances(arm, move, payload)
        late = time[away > CLOSE].max()
        assert late < 1.05 * arm.moves.times[move]
        assert away[-1] < CLOSE


def test_the_load_is_held_in_the_worst_posture(arm: SizedArm) -> None:
    q = arm.moves.ends
    torques = np.abs(rigid_torques(arm.machine, States(q, 0.0 * q, 0.0 * q), 1.0))
    worst = q[int((torques / [part.torque for part in arm.parts]).max(axis=1).argmax())]
    run = rollout(arm.machine, worst.tolist(), duration="1.5 s", payload=1.0, start=worst.tolist())
    away = np.linalg.norm(run["tip"].to_numpy() - tip_position(arm.machine, worst[None])[0], axis=1)
    assert away[run["time"].to_numpy() > 0.5].max() < CLOSE
