"""Environments of Gymnasium: arms that learners step, simulated or on a rig.

Importing this package registers them. Read in this order: tasks, machines, belt, pool, observation, rewards, vector.

Example:
    >>> import layflat as lf
    >>> import gymnasium
    >>> gymnasium.register_envs(lf.gym)
    >>> envs = gymnasium.make_vec("layflat/Reach-v0", 8, machines="nominal")
    >>> observations, infos = envs.reset(seed=1)
    >>> envs.close()
"""

from typing import TYPE_CHECKING

from layflat.extras import import_extra
from layflat.gym.tasks import ARM_TASKS
from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.gym.rig import RigEnv
    from layflat.gym.single import ArmEnv
    from layflat.gym.vector import ArmVectorEnv

__all__ = ["ARM_TASKS", "ArmEnv", "ArmVectorEnv", "RigEnv"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "ArmEnv": "layflat.gym.single:ArmEnv",
        "ArmVectorEnv": "layflat.gym.vector:ArmVectorEnv",
        "RigEnv": "layflat.gym.rig:RigEnv",
    },
)


def _register() -> None:
    """Register the environments of all tasks; raise MissingExtraError if Gymnasium is not installed."""
    registration = import_extra("gym", "gymnasium.envs.registration", where="layflat.gym")
    for name, task in ARM_TASKS.items():
        registration.register(
            f"layflat/{name}-v0",
            entry_point="layflat.gym.single:ArmEnv",
            vector_entry_point="layflat.gym.vector:ArmVectorEnv",
            max_episode_steps=task.episode_steps,
            kwargs={"task": name},
        )


_register()
