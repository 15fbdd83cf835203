"""Tasks of the environments: the arm, what is unknown of it, and what it is to do."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.signal_values import check_integer

MAX_POOL, MAX_DELAY, MAX_CYCLES = 10**6, 100, 10**4
MAX_EPISODE_STEPS = 10**9


@dataclass(frozen=True)
class Task:
    """Task of an environment."""

    title: str
    machine: str  # name of the described machine
    machines: str  # set from which each episode takes its arm: a key of `machines.MACHINE_SETS`
    episode_steps: int
    payloads: tuple[float, float] | None = None  # range from which each episode takes an unknown payload, kg
    goal: str = "point"  # "point" to reach, "belt" to follow, or "start" to hold
    loads: bool = False  # whether unknown torques push the joints


ARM_TASKS: Mapping[str, Task] = MappingProxyType({
    "Reach": Task("reach a point with the paper's arm", "paper-arm", "cloud", 100),
    "ReachUnknownPayload": Task(
        "reach a point with an unknown payload", "paper-arm-fast", "robust", 100, payloads=(0.0, 3.0)
    ),
    "TrackBelt": Task("follow a point on a moving belt", "paper-arm-fast", "robust", 100, goal="belt"),
    "PickingReach": Task(
        "reach a point in space under gravity, with an unknown payload", "picking-arm", "robust", 150,
        payloads=(0.0, 1.0),
    ),
    "HoldStiffness": Task(
        "hold a point against unknown torques", "paper-arm", "cloud", 150, goal="start", loads=True
    ),
})  # fmt: skip
"""Tasks by name; the environment's id is layflat/NAME-v0."""


@dataclass(frozen=True, kw_only=True)
class EnvOptions:
    """Options of an environment.

    Args:
        machine: a description, its file, or the name of a built-in machine; default: the task's.
        machines: set from which each episode takes its arm: "nominal", as described; "cloud", the machines that the
            paper allows; "robust", deviations of friction, losses, flow, supply and delay; "bouc-wen", these with
            another law of losses. Default: the task's.
        action: kind of action, as of `Batch`; an item of -1 to 1 covers the range of a joint.
        observe: "sensors", or "state" for true angles, velocities, pressures and payload.
        cycles: control cycles of a step of the environment.
        delay: control cycles by which readings are older than the step's end; at most `cycles`.
        pool: number of arms from which episodes take theirs.
        pool_seed: seed of the pool's machines, starts and goals; two seeds for arms to learn with and to test with.
        precision: "single" or "double".
        threads: number of threads of the batch; default: one per core.
    """

    machine: str | Machine | None = None
    machines: str | None = None
    action: str = "opening"
    observe: str = "sensors"
    cycles: int = 4
    delay: int = 1
    pool: int = 512
    pool_seed: int = 0
    precision: str = "single"
    threads: int | None = None

    def __post_init__(self) -> None:
        if self.observe not in ("sensors", "state"):
            raise InputError(f"{shown(self.observe)} is unknown", where="observe", right="use sensors or state")
        check_integer(self.cycles, "cycles", 1, MAX_CYCLES)
        check_integer(self.delay, "delay", 0, min(self.cycles, MAX_DELAY))
        check_integer(self.pool, "pool", 1, MAX_POOL)
        check_integer(self.pool_seed, "pool_seed", 0, 2**31)


def find_task(name: str) -> Task:
    """Return a task by its name, or by the id of its environment.

    Raises:
        InputError: there is no such task.
    """
    if not isinstance(name, str) or (key := name.removeprefix("layflat/").removesuffix("-v0")) not in ARM_TASKS:
        raise InputError(f"{shown(name)} is no task", where="task", right=f"use {', '.join(ARM_TASKS)}")
    return ARM_TASKS[key]


def read_options(options: Mapping[str, Any]) -> EnvOptions:
    """Return options by name as `EnvOptions`; raise InputError if one is unknown or wrong."""
    known = [field.name for field in fields(EnvOptions)]
    for name in options:
        if name not in known:
            raise InputError("is no option of an environment", where=name, right=f"use {', '.join(known)}")
    return EnvOptions(**options)
