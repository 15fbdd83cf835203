"""Environment of a rig: `RigEnv`, a task on hardware, or on a virtual rig, in real time."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from gymnasium import Env
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.errors import InputError, RigStoppedError
from layflat.gym.belt import belt_goals
from layflat.gym.observation import ArmObserver
from layflat.gym.pool import RANGE_FRACTION
from layflat.gym.tasks import MAX_EPISODE_STEPS, find_task, read_options
from layflat.gym.vector import first_info, read_actions
from layflat.machine import Machine, load
from layflat.motion.kinematics import Kinematics
from layflat.motion.path import half_strokes
from layflat.motion.signal_values import check_integer
from layflat.rig.driver import Driver
from layflat.rig.drivers import create_driver
from layflat.rig.safety.faults import RigState
from layflat.rig.session import RigSession, RigSnapshot
from layflat.rig.system import require_posix
from layflat.virtual_rig import SIMULATED_ADDRESS, simulated_rig

OBEYING_STATES = (RigState.READY, RigState.MOVING)  # states in which demands are obeyed
POLL_INTERVAL = 0.005  # between two looks at the rig's state, s
START_MARGIN = 20.0  # beyond the machine's own limit, for a start after a stop or the reset of a fault, s
MAX_SEED = 2**31


class RigEnv(Env[Any, Any]):
    """Task on a rig in real time: the environment that a simulated arm with `action="demand"` is.

    Actions are demands, -1 to 1 over the working stroke, to the machine's own control law; the supervisor limits and
    watches them as always, and ends an episode where it holds or vents: `info["fault"]` says why. What the reward needs
    comes from the sensors. A new episode goes on from where the arm is, after a start of the air where that is off.

    Args:
        task: name of a task, such as "Reach"; what pushes or loads the arm is up to you.
        driver: address of the rig, modbus://HOST:PORT or serial:///dev/NAME; "simulated" for a virtual one in the
            loop's own process; or a function that makes a `Driver`, which can be pickled.
        max_episode_steps: steps until an episode is truncated; default: the task's.
        options: `machine` and `cycles` of `EnvOptions`.

    Attributes:
        session: session on the rig.
        names: name of each item of an observation.

    Raises:
        InputError: an option, the machine or the address is wrong.
        RigLoopError: the rig does not answer, or another program drives it.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  # as Gymnasium has it

    def __init__(
        self, task: str, driver: str | Callable[[], Driver], *, max_episode_steps: int | None = None, **options: Any
    ) -> None:
        require_posix("RigEnv")
        self._task, self._options = find_task(task), read_options({"action": "demand"} | options)
        _check_options(self._options.action, self._options.observe)
        self._machine = machine = load(self._task.machine if self._options.machine is None else self._options.machine)
        limit = self._task.episode_steps if max_episode_steps is None else max_episode_steps
        self._limit = check_integer(limit, "max_episode_steps", 1, MAX_EPISODE_STEPS)
        self._half, self._period = half_strokes(machine), self._options.cycles * machine.cycle
        self._observer = ArmObserver(machine, 1, self._options, moving=self._task.goal == "belt")
        self._kinematics = Kinematics(machine)
        self.names, self.observation_space = self._observer.names, self._observer.space
        self.action_space = Box(-1.0, 1.0, (len(self._half),), np.float32)
        self._seen, self._tip = np.zeros((len(self._half), 2, 1)), np.zeros((3, 1))
        self._due, self._begun, self._closed = 0.0, False, False
        self.session = RigSession(machine, _driver_at(driver, machine))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Start the air where it is off, take a new goal, and return the first observation and information.

        Args:
            seed: seed of the goals that follow; None: the generator goes on.
            options: none so far.

        Raises:
            InputError: an option is unknown, or the environment is closed.
            RigStoppedError: the rig does not start, for the fault that the message names.
            RigLoopError: the rig's loop has ended.
        """
        self._check_open()
        super().reset(seed=seed)
        for name in options or {}:
            raise InputError("is no option of reset", where=str(name), right="give none")
        shot = self._start_air()
        self._observer.bind(self._seen, self._tip, *self._draw_goal(shot["measured_angle"]))
        self._seen[:, 0, 0] = shot["measured_angle"]
        self._observer.restart()
        self._observer.steps[0], self._begun, self._due = 0, True, time.monotonic()
        return self._observe(shot, 0.0), first_info(self._observer.info())

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Demand angles, and wait until the step is over.

        Args:
            action: (joints,), -1 to 1 over the working stroke.

        Returns:
            Observation (items,), reward, whether the supervisor ended the episode, whether it is over, information.

        Raises:
            InputError: the action has another shape or is no number; the environment is closed or was not reset.
            RigLoopError: the rig's loop has ended.
        """
        self._check_open()
        if not self._begun:
            raise InputError("has not begun", where="environment", right="call reset first")
        values = read_actions(action, self.action_space.shape).clip(-1.0, 1.0)
        self.session.ask((self._half * values).tolist())
        self._due = max(self._due + self._period, time.monotonic())
        time.sleep(max(self._due - time.monotonic(), 0.0))
        self._observer.steps += 1
        shot = self._last_snapshot()
        observation, reward = self._observe(shot, values[:, None]), float(self._observer.rewards[0])
        info, stopped = first_info(self._observer.info()), shot.state not in OBEYING_STATES
        if stopped:
            info["fault"] = shot.fault_text
        return observation, reward, stopped, bool(self._observer.steps[0] >= self._limit), info

    def close(self) -> None:
        """Stop the arm, vent the air, and end the session; a second call does nothing."""
        self._closed = True
        self.session.close()

    def _observe(self, shot: RigSnapshot, action: Array | float) -> Array:
        """Return the observation of a snapshot after an action, (items,)."""
        self._seen[:, 0, 0], self._seen[:, 1, 0] = shot["measured_angle"], shot["measured_pressure"]
        self._tip[:, 0] = self._kinematics.tip(shot["measured_angle"][None])[0]
        self._observer.read_sensors()
        self._observer.action[:] = action
        return self._observer.compare()[:, 0]

    def _draw_goal(self, angles: Array) -> tuple[Array, Array]:
        """Return the goal of an episode that begins at angles, (joints,), rad, as `Pool` has goals and their tips."""
        limits: Array = RANGE_FRACTION * self._half
        if self._task.goal == "belt":
            times = self._period * np.arange(self._task.episode_steps + 1, dtype=np.float64)
            seed = int(self.np_random.integers(MAX_SEED))
            return belt_goals(self._machine, angles[None], times, limits, seed)
        goal = angles if self._task.goal == "start" else self.np_random.uniform(-limits, limits)
        return goal[None, :, None], self._kinematics.tip(goal[None]).T[None]

    def _start_air(self) -> RigSnapshot:
        """Start the air if it is off, reset a fault that is over, and return a snapshot in which demands are obeyed."""
        give_up = time.monotonic() + self._machine.safety.start_time + START_MARGIN
        requested: RigState | None = None
        while (shot := self._last_snapshot()).state not in OBEYING_STATES:
            if shot.state is not requested and shot.state is not RigState.STARTING:
                requested = shot.state
                (self.session.reset if shot.state is RigState.FAULT else self.session.start)()
            if time.monotonic() > give_up:
                raise RigStoppedError(f"the rig did not start: {shot.fault_text}")
            time.sleep(POLL_INTERVAL)
        return shot

    def _last_snapshot(self) -> RigSnapshot:
        """Return the snapshot of the last cycle; raise RigLoopError if the loop has ended."""
        while (shot := self.session.snapshot()) is None:
            self.session.check()
            time.sleep(POLL_INTERVAL)
        self.session.check()
        return shot

    def _check_open(self) -> None:
        """Raise InputError if the environment is closed."""
        if self._closed:
            raise InputError("is closed", where="environment", right="make a new one")


def _check_options(action: str, observe: str) -> None:
    """Raise InputError unless a rig has such actions and observations."""
    if action != "demand":
        what = f"{action!r} is nothing that a rig obeys: its supervisor moves the valves by the machine's law"
        raise InputError(what, where="action", right="use demand")
    if observe != "sensors":
        raise InputError("a rig shows its sensors alone", where="observe", right="use sensors")


def _driver_at(driver: str | Callable[[], Driver], machine: Machine) -> Callable[[], Driver]:
    """Return a function that makes the driver of an address; raise InputError if it is no address."""
    if not isinstance(driver, str):
        return driver
    if driver == SIMULATED_ADDRESS:
        return partial(simulated_rig, machine)
    factory = partial(create_driver, driver, machine)
    factory()  # it connects later, in the process that needs it
    return factory
