"""Pictures of environments, and the page that shows an arm."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from layflat.errors import InputError
from layflat.gym.single import ArmEnv
from layflat.gym.vector import ArmVectorEnv

pytestmark = pytest.mark.compiled

FEW: dict[str, Any] = {"machines": "nominal", "pool": 4}


@pytest.mark.usefixtures("opengl")
def test_pictures_show_the_arms_as_they_move() -> None:
    pytest.importorskip("mujoco")
    env = gymnasium.make("layflat.gym:layflat/Reach-v0", render_mode="rgb_array", **FEW)
    env.reset(seed=1)
    before = env.render()
    for _ in range(20):
        env.step(np.ones(2, np.float32))
    after = env.render()
    assert isinstance(before, np.ndarray)
    assert isinstance(after, np.ndarray)
    assert before.dtype == np.uint8
    assert before.shape == after.shape
    assert before.ndim == 3
    assert (before != after).any()
    env.close()
    envs = ArmVectorEnv("Reach", 2, render_mode="rgb_array", **FEW)
    envs.reset(seed=1)
    pictures = envs.render()
    assert pictures is not None
    assert len(pictures) == 2
    assert (pictures[0] != pictures[1]).any()
    envs.close()


def test_a_page_follows_the_arm_in_the_pace_of_its_motion() -> None:
    pytest.importorskip("viser")
    env = ArmEnv("Reach", render_mode="human", cycles=1, **FEW)
    assert env.viewer_address.startswith("http://127.0.0.1:")
    env.reset(seed=1)
    for _ in range(5):
        env.step([1.0, 1.0])
    assert env.render() is None
    env.close()


def test_rendering_without_a_mode_is_one_line() -> None:
    env = ArmEnv("Reach", **FEW)
    env.reset(seed=1)
    with pytest.raises(InputError, match="render_mode: is not set; use rgb_array or human"):
        env.render()
    env.close()
