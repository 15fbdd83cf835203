"""Environment of many arms that are stepped together: `ArmVectorEnv`."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from layflat.arrays import Array, Picture
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.gym.kernel import scale_actions
from layflat.gym.loads import LoadSchedule
from layflat.gym.observation import ArmObserver
from layflat.gym.pool import make_batch, make_pool
from layflat.gym.rendering import RENDER_MODES, ArmRenderer, check_render_mode
from layflat.gym.tasks import MAX_EPISODE_STEPS, find_task, read_options
from layflat.motion.scenario import MAX_SEED
from layflat.motion.signal_values import check_integer
from layflat.sim.batch.actions import find_action
from layflat.sim.batch.state import check_arms

RESET_OPTIONS = ("reset_mask", "arms")


class ArmVectorEnv(VectorEnv[Array, Array, Array]):
    """Many arms with one task each, as a vector environment of Gymnasium on one `Batch`.

    Actions are numbers of -1 to 1, those beyond are clipped. Observations are rows of `names`; see
    `layflat.gym.observation`. An episode ends by `max_episode_steps`; it is terminated only where an arm diverges.
    Information of a step has `distance` (m) of the tip from its goal, and `is_success` within 2 mm, (num_envs,) each.

    Args:
        task: name of a task, such as "Reach".
        num_envs: number of arms.
        max_episode_steps: steps until an episode is truncated; None: never.
        autoreset_mode: mode of Gymnasium, or its name: "NextStep", "SameStep" or "Disabled", in which
            `reset(options={"reset_mask": mask})` begins the episodes of some arms.
        render_mode: "rgb_array", "human", a page in the browser that shows the first arm, or None.
        options: further options by name, see `EnvOptions`.

    Attributes:
        batch: the batch of the arms.
        names: name of each item of an arm's observation.

    Raises:
        InputError: an option or the machine is wrong.

    Example:
        >>> import layflat as lf
        >>> import numpy as np
        >>> with_arms = lf.gym.ArmVectorEnv("Reach", 16, machines="nominal", pool=32)
        >>> observations, _ = with_arms.reset(seed=1)
        >>> observations, rewards, *_ = with_arms.step(np.zeros((16, 2)))
        >>> observations.shape, bool((rewards < 0.0).all())
        ((16, 10), True)
        >>> with_arms.close()
    """

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        *,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        self._task, self._options = find_task(task), read_options(options)
        self.num_envs = check_integer(num_envs, "num_envs", 1)
        self._mode, self.render_mode = _read_mode(autoreset_mode), check_render_mode(render_mode)
        if max_episode_steps is not None:
            check_integer(max_episode_steps, "max_episode_steps", 1, MAX_EPISODE_STEPS)
        self._limit = MAX_EPISODE_STEPS if max_episode_steps is None else max_episode_steps
        self._pool = pool = make_pool(self._task, self._options)
        self.batch = make_batch(pool.described, pool.machine, self.num_envs, self._options)
        self._observer = ArmObserver(pool.machine, self.num_envs, self._options, moving=len(pool.goals) > 1)
        self._observer.bind(self.batch.arrays.seen, self.batch.arrays.tips, pool.goals, pool.goal_tips)
        self._renderer = None if self.render_mode is None else ArmRenderer(pool.machine, self.render_mode)
        self._name_spaces()
        self._steps = self._observer.steps  # of the present episodes
        pushed = self._task.loads
        self._loads = LoadSchedule(pool.machine, self._steps, self.batch.arrays.acting) if pushed else None
        self._first_end = 0  # steps until the first episode may end
        self._done, self._any_done, self._begun = np.zeros(self.num_envs, bool), False, False
        # Observations are kept where a mask may leave out arms.
        self._latest: Array = np.zeros((len(self.names), self.num_envs), np.float32)
        self._all = np.ones(self.num_envs, bool)
        self._all.flags.writeable = False

    def _name_spaces(self) -> None:
        """Set spaces, metadata and the scale of actions."""
        low, high = self.batch.action_limits
        self.names = self._observer.names
        self.single_action_space = Box(-1.0, 1.0, (len(low),), np.float32)
        self.single_observation_space = self._observer.space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._actions, self._scaled = np.zeros((2, self.num_envs, len(low)))
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        self._scale = scale_actions.bind(self._actions, middle, half, self._scaled, self._observer.action)
        kind = find_action(self._options.action)
        self._input = None if kind.of_valve else self.batch.inputs[kind.signal]  # written without the batch's checks
        fps = round(1.0 / (self._options.cycles * self.batch.cycle))
        self.metadata = {"render_modes": list(RENDER_MODES), "render_fps": fps, "autoreset_mode": self._mode}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin episodes and return observations, (num_envs, items), and information.

        Args:
            seed: seed of all that follows; None: the generator goes on.
            options: "reset_mask", a mask of the arms whose episodes begin, default: all; "arms", numbers of the
                pool's arms that these episodes have, with their starts and goals, default: drawn.

        Raises:
            InputError: an option is wrong, or the environment is closed.
        """
        self._check_open()
        mask, of_pool = _read_reset_options(options, self.num_envs, self._pool.count)
        if seed is not None:
            check_integer(seed, "seed", 0)
        super().reset(seed=seed)
        if not self._begun and not mask.all():
            raise InputError("leaves out arms that have not begun", where="reset_mask", right="reset all first")
        self._begun = True
        arms = np.flatnonzero(mask)
        self._begin_episodes(arms, of_pool)
        self._done = self._done & ~mask
        self._any_done = bool(self._done.any())
        rows = self._latest.copy()
        rows[:, arms] = self._observe_start()[:, arms]
        self._latest[:] = rows
        self._show()
        return rows.T, self._info()

    def step(self, actions: ArrayLike) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:  # type: ignore[override]
        """Move all arms by a step.

        Args:
            actions: (num_envs, joints), -1 to 1.

        Returns:
            Observations (num_envs, items), rewards, terminations, truncations, (num_envs,) each, and information.

        Raises:
            InputError: actions have another shape or are no numbers; the environment is closed or was not reset.
        """
        self._check_open()
        if not self._begun:
            raise InputError("has not begun", where="environment", right="call reset first")
        self._actions[:] = read_actions(actions, self.action_space.shape)
        self._move()
        self._steps += 1
        rows = self._observer.compare()
        rewards, infos = self._observer.rewards, self._info()
        terminations, truncations = self.batch.diverged.copy(), self._truncations()
        if self._any_done and self._mode is AutoresetMode.NEXT_STEP:
            again = self._done
            rewards[again], terminations[again], truncations[again] = 0.0, False, False
            self._restart(rows, np.flatnonzero(again), infos)
        self._done = np.logical_or(terminations, truncations)
        self._any_done = bool(np.count_nonzero(self._done))
        if self._any_done and self._mode is AutoresetMode.SAME_STEP:
            self._restart_at_once(rows, infos)
        if self._mode is AutoresetMode.DISABLED:
            self._latest[:] = rows
        self._show()
        return rows.T, rewards, terminations, truncations, infos

    def _move(self) -> None:
        """Move the batch by the actions, and read what is observed; raise InputError as `step` does."""
        batch, (cycles, delay) = self.batch, (self._options.cycles, self._options.delay)
        if self._loads is not None:
            self._loads.push()
        action: Array | None = self._scaled
        if not self._scale() and self._input is not None:
            self._input[:] = action
            action = None
        if self._options.observe == "state":
            delay = 0
        if delay < cycles:
            batch.step(action, cycles - delay)
            action = None
        self._read(keeps=True)
        if delay:
            batch.step(action, delay)

    def _read(self, *, keeps: bool) -> None:
        """Read what is observed; where `keeps`, the coming rates are counted from these readings."""
        if self._options.observe == "state":
            self._observer.read_state(self.batch)
        else:
            self._observer.read_sensors(keeps=keeps)

    def _truncations(self) -> NDArray[np.bool_]:
        """Return which episodes have reached their last step."""
        self._first_end -= 1
        if self._first_end > 0:
            return np.zeros(self.num_envs, bool)
        ended: NDArray[np.bool_] = self._steps >= self._limit
        return ended

    def _begin_episodes(self, arms: NDArray[np.intp], of_pool: NDArray[np.intp] | None = None) -> None:
        """Begin the episodes of some arms: each has an arm of the pool, by default drawn, its goal, and new noise."""
        draw = self.np_random
        rows = draw.integers(self._pool.count, size=len(arms)) if of_pool is None else of_pool
        seeds = draw.integers(MAX_SEED, size=len(arms))
        self.batch.set_state(self._pool.rest.take(rows), arms, seed=seeds)
        self._observer.of_pool[arms], self._steps[arms] = rows, 0
        if self._loads is not None:
            self._loads.restart(draw, arms)
        self._observer.restart(arms)
        self._first_end = self._limit - int(self._steps.max())

    def _observe_start(self) -> Array:
        """Return the rows of the observation of arms that stand at the start, with no action before."""
        self._read(keeps=False)
        self._observer.action[:] = 0.0
        return self._observer.compare()

    def _restart(self, rows: Array, arms: NDArray[np.intp], infos: dict[str, Any]) -> None:
        """Begin episodes of some arms within a step, and write their first observations and information."""
        self._begin_episodes(arms)
        rows[:, arms] = self._observe_start()[:, arms]
        infos |= self._observer.info()

    def _restart_at_once(self, rows: Array, infos: dict[str, Any]) -> None:
        """Begin the episodes that have just ended, after keeping their last observations and information."""
        final = np.full(self.num_envs, None, object)
        for arm in np.flatnonzero(self._done):
            final[arm] = rows[:, arm].copy()
        last = {name: values.copy() for name, values in infos.items()} | {
            f"_{name}": self._done.copy() for name in infos if not name.startswith("_")
        }
        self._restart(rows, np.flatnonzero(self._done), infos)
        infos |= {"final_obs": final, "_final_obs": self._done.copy()}
        infos |= {"final_info": last, "_final_info": self._done.copy()}

    def _info(self) -> dict[str, Any]:
        """Return the information of all arms, with the masks of Gymnasium."""
        return self._observer.info() | {"_distance": self._all, "_is_success": self._all}

    @property
    def viewer_address(self) -> str:
        """Address of the page that shows the first arm; empty without one."""
        return "" if self._renderer is None else self._renderer.address

    def _show(self) -> None:
        """Show the first arm in the browser, where that is the mode of rendering."""
        if self._renderer is not None:
            self._renderer.show(self.batch.angle[0], self._options.cycles * self.batch.cycle)

    def render(self) -> tuple[Picture, ...] | None:
        """Return the pictures of all arms, (height, width, 3) each; None where they are shown in the browser.

        Raises:
            InputError: the environment has no mode of rendering.
            NoDrawingError: there is no OpenGL.
        """
        if self._renderer is None:
            raise InputError("is not set", where="render_mode", right=f"use {' or '.join(RENDER_MODES)}")
        if self.render_mode == "human":
            return None
        return tuple(self._renderer.picture(angles) for angles in self.batch.angle)

    def close_extras(self, **_: Any) -> None:
        """End the threads of the batch, and the page."""
        self.batch.close()
        if self._renderer is not None:
            self._renderer.close()

    def _check_open(self) -> None:
        """Raise InputError if the environment is closed."""
        if self.closed:
            raise InputError("is closed", where="environment", right="make a new one")


def _read_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Return a mode of autoreset; raise InputError if there is no such mode."""
    try:
        return AutoresetMode(mode)
    except ValueError:
        names = ", ".join(one.value for one in AutoresetMode)
        raise InputError(f"{shown(mode)} is unknown", where="autoreset_mode", right=f"use {names}") from None


def _read_reset_options(
    options: Mapping[str, Any] | None, count: int, pool: int
) -> tuple[NDArray[np.bool_], NDArray[np.intp] | None]:
    """Return the mask of the arms to reset, (count,), and the numbers of their arms in the pool, None for a draw.

    Raise InputError if an option is unknown or wrong.
    """
    given = dict(options or {})
    mask = np.asarray(given.pop("reset_mask", np.ones(count, bool)))
    if mask.dtype != bool or mask.shape != (count,) or not mask.any():
        right = f"give a mask of {count} arms, at least one of them True"
        raise InputError(f"has shape {mask.shape} and holds {mask.dtype}", where="reset_mask", right=right)
    of_pool = None
    if "arms" in given:
        of_pool = check_arms(given.pop("arms"), pool, "arms")
        if len(of_pool) != mask.sum():
            right = "give one for each episode that begins"
            raise InputError(f"holds {len(of_pool)} arms for {mask.sum()} episodes", where="arms", right=right)
    for name in given:
        raise InputError("is no option of reset", where=str(name), right=f"use {', '.join(RESET_OPTIONS)}")
    return mask, of_pool


def read_actions(actions: ArrayLike, shape: tuple[int, ...] | None) -> Array:
    """Return actions as an array; raise InputError if they hold no numbers, or have another shape."""
    values = np.asarray(actions)
    if values.dtype.kind not in "fiu" or values.shape != shape:
        what = f"has shape {values.shape}" if values.dtype.kind in "fiu" else f"{shown(actions)} holds no numbers"
        raise InputError(what, where="action", right=f"give numbers of shape {shape}")
    return values


def first_info(infos: Mapping[str, Any]) -> dict[str, Any]:
    """Return the information of the first arm as plain numbers, without masks."""
    return {name: values[0].item() for name, values in infos.items() if not name.startswith("_")}
