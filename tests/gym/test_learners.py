"""Learners of other packages run on the environments as they are."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import layflat.gym
from tests.programs import skip_without

gymnasium.register_envs(layflat.gym)

FEW: dict[str, Any] = {"machines": "nominal", "pool": 8}


@pytest.mark.compiled
@pytest.mark.filterwarnings("ignore")  # of PyTorch
def test_stable_baselines_learns_saves_and_acts(tmp_path: Path) -> None:
    if find_spec("stable_baselines3") is None:
        skip_without("stable-baselines3")
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_checker import check_env
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import VecNormalize

    env = gymnasium.make("layflat/Reach-v0", **FEW)
    check_env(env)
    envs = VecNormalize(make_vec_env("layflat/Reach-v0", n_envs=4, env_kwargs=FEW, seed=1))
    model = PPO("MlpPolicy", envs, n_steps=128, batch_size=128, n_epochs=2, seed=1, device="cpu")
    before = [value.clone() for value in model.policy.parameters()]
    model.learn(2 * 4 * 128)
    assert any((old != new).any() for old, new in zip(before, model.policy.parameters(), strict=True))
    assert len(model.ep_info_buffer) == 2 * 128 // 100 * 4  # episodes of 100 steps, as `Monitor` counts them
    model.save(tmp_path / "policy")
    policy = PPO.load(tmp_path / "policy", device="cpu")
    observation, _ = env.reset(seed=1)
    action, _ = policy.predict(observation, deterministic=True)
    assert np.isfinite(env.step(action)[0]).all()
    env.close()
    envs.close()
