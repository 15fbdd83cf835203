"""The environment of a rig, virtual, in real time: moves, faults, two on one rig, wrong arguments."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.passive_env_checker import env_reset_passive_checker, env_step_passive_checker

from layflat.errors import InputError
from layflat.gym.rig import RigEnv
from layflat.gym.vector import ArmVectorEnv
from layflat.machine import changed, load
from layflat.rig.device.process import DeviceProcess, ModbusPort
from layflat.rig.session import RigLoopError
from layflat.virtual_rig import VirtualRig, simulated_rig
from tests.rig import fake_drivers

pytestmark = [pytest.mark.compiled, pytest.mark.realtime]

FAST = load("paper-arm-fast")


@pytest.fixture(autouse=True)
def own_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAYFLAT_RUNTIME_DIR", str(tmp_path / "locks"))


def goal_action(env: RigEnv, observation: Any) -> Any:
    """Return the action that demands the goal."""
    named = dict(zip(env.names, observation, strict=True))
    return np.array([named[f"angle {j}"] + named[f"error {j}"] for j in ("large", "small")]) * 75.0 / 60.0


def test_an_arm_reaches_goals_and_is_observed_as_a_simulated_one() -> None:
    env = RigEnv("Reach", "simulated", machine=FAST, max_episode_steps=80)
    envs = ArmVectorEnv("Reach", 1, machine=FAST, machines="nominal", action="demand", pool=4)
    assert (env.names, env.observation_space) == (envs.names, envs.single_observation_space)
    assert env.action_space == envs.single_action_space
    envs.close()
    env_reset_passive_checker(env)
    env_step_passive_checker(env, np.zeros(2, np.float32))
    for seed in (1, 2):
        observation, info = env.reset(seed=seed)
        assert info["distance"] > 0.005
        action, ends = goal_action(env, observation), []
        for _ in range(80):
            observation, reward, terminated, truncated, info = env.step(action)
            assert observation in env.observation_space
            ends.append(truncated)
            assert not terminated, info
        assert ends == [False] * 79 + [True]
        assert info["distance"] < 0.02
        assert reward > -1.0
    env.close()
    env.close()
    for call in (lambda: env.step(action), env.reset):
        with pytest.raises(InputError, match="environment: is closed; make a new one"):
            call()


def test_a_belt_and_a_hold_begin_where_the_arm_is() -> None:
    for task in ("TrackBelt", "HoldStiffness"):
        env = RigEnv(task, partial(simulated_rig, FAST), machine=FAST)
        observation, info = env.reset(seed=1)
        assert info["distance"] < 1e-3
        observation, _, terminated, _, info = env.step(goal_action(env, observation))
        assert info["distance"] < 0.02
        assert not terminated, info
        env.close()


def test_the_supervisor_ends_an_episode_and_a_reset_begins_the_next() -> None:
    env = RigEnv("Reach", "simulated", machine=FAST)
    observation, _ = env.reset(seed=1)
    action = goal_action(env, observation)
    assert not env.step(action)[2]
    env.session.stop()
    ends = [env.step(action) for _ in range(10)]
    assert ends[-1][2]
    assert ends[-1][4]["fault"] == "stopped by the loop"
    env.reset()
    assert not env.step(action)[2]
    env.close()


def test_two_environments_on_one_rig_are_refused() -> None:
    machine = changed(FAST, "interface.modbus.timeout", "20 ms")
    with DeviceProcess(VirtualRig(machine), machine, ModbusPort(0)) as device:
        address = device.address
        env = RigEnv("Reach", address, machine=machine)
        with pytest.raises(RigLoopError, match=r"is driven by .* already; one loop drives a rig"):
            RigEnv("Reach", address, machine=machine)
        env.close()


def test_a_loop_that_breaks_is_reported() -> None:
    env = RigEnv("Reach", fake_drivers.breaking)
    env.session.process.join(10.0)
    with pytest.raises(RigLoopError, match="out of order"):
        env.reset()
    env.close()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"action": "opening"}, "action: 'opening' is nothing that a rig obeys"),
        ({"observe": "state"}, "observe: a rig shows its sensors alone; use sensors"),
        ({"driver": "http://arm"}, "http://arm: is not a driver's address"),
        ({"max_episode_steps": 0}, "max_episode_steps: 0 is out of range"),
        ({"task": "Fly"}, "task: 'Fly' is no task"),
    ],
)
def test_wrong_options_are_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        RigEnv(**{"task": "Reach", "driver": "simulated", **options})
    assert message in str(caught.value)


def test_wrong_calls_are_named() -> None:
    env = RigEnv("Reach", "simulated", machine=FAST)
    with pytest.raises(InputError, match="has not begun; call reset first"):
        env.step([0.0, 0.0])
    with pytest.raises(InputError, match="goal: is no option of reset"):
        env.reset(options={"goal": 1})
    env.reset()
    with pytest.raises(InputError, match=r"has shape \(3,\); give numbers of shape \(2,\)"):
        env.step([0.0, 0.0, 0.0])
    with pytest.raises(InputError, match="angles"):
        env.step([0.0, np.nan])
    env.close()
