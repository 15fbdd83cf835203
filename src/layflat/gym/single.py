"""Environment of one arm: `ArmEnv`."""

from typing import Any

import numpy as np
from gymnasium import Env
from gymnasium.vector import AutoresetMode
from numpy.typing import ArrayLike

from layflat.arrays import Array, Picture
from layflat.gym.rendering import RENDER_MODES
from layflat.gym.vector import ArmVectorEnv, first_info

USUAL_FPS = 50  # of environments with the usual options; each has its own in its `metadata`


class ArmEnv(Env[Array, Array]):
    """One arm with a task, as an environment of Gymnasium; it is an `ArmVectorEnv` of one.

    Args:
        task: name of a task, such as "Reach".
        render_mode: "rgb_array", "human", a page in the browser, or None.
        options: further options by name, see `EnvOptions`.

    Attributes:
        names: name of each item of an observation.
        viewer_address: address of the page; empty without one.

    Raises:
        InputError: an option or the machine is wrong.

    Example:
        >>> import gymnasium
        >>> env = gymnasium.make("layflat.gym:layflat/Reach-v0", machines="nominal")
        >>> observation, _ = env.reset(seed=1)
        >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        >>> env.unwrapped.names[0], env.unwrapped.names[-1]
        ('angle large', 'error small')
        >>> env.close()
    """

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": USUAL_FPS}  # noqa: RUF012  # as Gymnasium has it

    def __init__(self, task: str, *, render_mode: str | None = None, **options: Any) -> None:
        self._arms = ArmVectorEnv(
            task, 1, autoreset_mode=AutoresetMode.DISABLED, render_mode=render_mode, **{"threads": 1} | options
        )
        arms = self._arms
        self.render_mode, self.names = render_mode, arms.names
        self.observation_space, self.action_space = arms.single_observation_space, arms.single_action_space
        self.metadata = {"render_modes": list(RENDER_MODES), "render_fps": arms.metadata["render_fps"]}
        self.viewer_address = arms.viewer_address

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode, and return its first observation and information.

        Args:
            seed: seed of all that follows; None: the generator goes on.
            options: none so far.

        Raises:
            InputError: an option is unknown, or the environment is closed.
        """
        super().reset(seed=seed)
        self._arms.np_random = self.np_random
        observations, infos = self._arms.reset(options=options)
        return observations[0].copy(), first_info(infos)

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Move the arm by a step.

        Args:
            action: (joints,), -1 to 1.

        Returns:
            Observation (items,), reward, whether the arm diverged, False, and information.

        Raises:
            InputError: the action has another shape or is no number; the environment is closed or was not reset.
        """
        observations, rewards, terminations, _, infos = self._arms.step(np.asarray(action)[None])
        return observations[0].copy(), float(rewards[0]), bool(terminations[0]), False, first_info(infos)

    def render(self) -> Picture | None:
        """Return a picture, (height, width, 3); None where the arm is shown in the browser."""
        pictures = self._arms.render()
        return None if pictures is None else pictures[0]

    def close(self) -> None:
        """End the environment, and the page."""
        self._arms.close()
