"""Step response of a joint as a cloud of runs over tolerances and payloads: an `ensemble` that keeps traces."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import radians
from typing import Self

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError, MachineError
from layflat.machine.model import Machine
from layflat.motion.scenario import Scenario
from layflat.pages.studio.results import DesignQuantity
from layflat.physics.step import COARSE_STEP, STEP
from layflat.sim.ensemble import ensemble
from layflat.sim.metrics import SETTLING_BAND

DEFAULT_RUNS = 256  # a power of two, for Sobol's points
STEP_DELAY = 0.1  # time before the step, s
MAX_CYCLES = 4000  # control cycles of a run: sensor noise of all runs is in memory at once
CYCLES_PER_RECORD = 4  # control cycles between two records
SIGNALS = ("angle", "pressure_a", "pressure_b")
QUANTILE_LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
MAX_SINGLE_RUNS = 6  # runs that are drawn as single lines
MAX_FINE_JOINTS = (
    2  # joints of an arm that is simulated with the default step; with more the coarse step is used, as in tuning
)


class OvertakenError(Exception):
    """Signal that a simulation is obsolete: a newer design waits."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of the runs: relative half ranges, and payloads from zero to a multiple of the described one."""

    valve: float = 0.1
    friction: float = 0.2
    supply: float = 0.1
    losses: float = 0.3
    payload: float = 1.0


@dataclass(frozen=True)
class JointStep:
    """Step of one joint about mid-stroke, while the others stay at mid-stroke."""

    joint: str
    size: float = radians(40.0)  # rad
    duration: float = 1.5  # s, from the step on


@dataclass(frozen=True)
class StepCloud:
    """Results of the runs of a step, the first of them nominal; arrays are (runs,) or (runs, instants)."""

    step: JointStep
    time: Array  # s, from the step on, (instants,)
    angle: Array  # rad
    pressure_a: Array  # absolute, Pa
    pressure_b: Array
    settling: Array  # s; infinite where a run does not settle, NaN where it diverged
    overshoot: Array  # rad
    air: Array  # normal litres, the sum of all joints
    hysteresis: float  # of the nominal run, fraction
    plant_step: float  # s
    seconds: float  # computing time

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.settling)

    @cached_property
    def sound(self) -> NDArray[np.bool_]:
        """Mask of the runs that did not diverge, (runs,)."""
        return np.isfinite(self.overshoot)

    @cached_property
    def levels(self) -> dict[str, Array]:
        """`QUANTILE_LEVELS` of the signals over all runs that did not diverge, (levels, instants) each, SI."""
        return {name: np.quantile(getattr(self, name)[self.sound], QUANTILE_LEVELS, axis=0) for name in SIGNALS}

    def rank(self) -> Self:
        """Compute and cache `levels`, which takes long, so that they travel between processes; return this cloud."""
        if self.sound.any():
            _ = self.levels
        return self

    def settled(self, fraction: float) -> float:
        """Return the time in which a fraction of all runs has settled, s; infinite where fewer settle."""
        times = np.sort(np.where(self.sound, self.settling, np.inf))
        return float(times[min(len(times) - 1, int(np.ceil(fraction * len(times))) - 1)])

    @property
    def late(self) -> int:
        """Number of runs that have not settled by the end, diverged ones included."""
        return int(np.sum(~np.isfinite(self.settling)))

    @property
    def diverged(self) -> int:
        """Number of runs that diverged."""
        return int(np.sum(~self.sound))

    @property
    def quantities(self) -> list[DesignQuantity]:
        """Quantities that are compared between designs."""
        return [
            DesignQuantity("settled, half of all runs", self.settled(0.5), "s", 3),
            DesignQuantity("settled, 95 % of all runs", self.settled(0.95), "s", 3),
            DesignQuantity("runs that do not settle", float(self.late), f"of {self.runs}", 3),
            DesignQuantity("overshoot, nominal", float(np.degrees(self.overshoot[0])), "deg", 2),
            DesignQuantity("air of the move, nominal", float(self.air[0]), "normal l", 3),
            DesignQuantity("hysteresis, brake on", 100 * self.hysteresis, "%", 3),
        ]

    @property
    def summary(self) -> str:
        """Sentences about the times in which the runs settle."""
        band = f"within {np.degrees(SETTLING_BAND):.2g} deg"
        shares = [f"{100 * share:.0f} % in {self.settled(share):.2f} s" for share in QUANTILE_LEVELS[2:]
                  if np.isfinite(self.settled(share))]  # fmt: skip
        text = f"Settled {band}: {', '.join(shares)}." if shares else f"Fewer than half of the runs settle {band}."
        if self.late:
            text += f" {self.late} of {self.runs} runs do not settle in {self.step.duration:g} s."
        return text + (f" {self.diverged} runs diverged and are not drawn." if self.diverged else "")


def default_step(machine: Machine) -> JointStep:
    """Return the step that is shown first: of the first joint, 0.8 s long with more than `MAX_FINE_JOINTS` joints."""
    duration = JointStep.duration if len(machine.joints) <= MAX_FINE_JOINTS else 0.8
    return JointStep(next(iter(machine.joints)), duration=duration)


def step_scenario(machine: Machine, step: JointStep) -> Scenario:
    """Return the scenario of a step after `STEP_DELAY`, from minus to plus half its size; other joints stay at 0."""
    half_size = step.size / 2
    before, after = ({**dict.fromkeys(machine.joints, 0.0), step.joint: sign * half_size} for sign in (-1.0, 1.0))
    return Scenario(demand=[(0.0, before), (STEP_DELAY, after)], duration=STEP_DELAY + step.duration)


def vary_parameters(machine: Machine, tolerances: Tolerances, runs: int) -> dict[str, Array]:
    """Return the varied values by path, SI, (runs,) each; the first run is nominal, the others are Sobol points.

    Paths are those of the machine and of `scenario`; `seed` has other sensor noise for each run.

    Args:
        machine: nominal machine.
        tolerances: ranges of the values.
        runs: number of runs, a power of two.
    """
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    share = qmc.Sobol(5, seed=1).random(runs)
    about = 2.0 * share - 1.0
    about[0] = 0.0
    payload = machine.arm.payload * tolerances.payload * share[:, 4]
    payload[0] = machine.arm.payload
    vary = {
        "supply.pressure_gauge": machine.supply.pressure_gauge * (1.0 + tolerances.supply * about[:, 0]),
        "scenario.brake": 1.0 + tolerances.friction * about[:, 1],
        "arm.payload": payload,
        "seed": np.arange(runs, dtype=float),
    }
    for name, joint in machine.joints.items():
        vary[f"joint.{name}.valve_size"] = joint.valve_size * (1.0 + tolerances.valve * about[:, 2])
        for part, usual in (("hose", joint.hose.loss_fraction), ("strap", joint.strap.loss_fraction)):
            shares = usual * (1.0 + tolerances.losses * about[:, 3])
            vary[f"joint.{name}.{part}.loss_fraction"] = np.minimum(shares, 1.0)
    return vary


def simulate_cloud(
    machine: Machine, step: JointStep, tolerances: Tolerances | None = None, *, runs: int = DEFAULT_RUNS,
    overtaken: Callable[[], bool] = lambda: False,
) -> StepCloud:  # fmt: skip
    """Simulate a step in many runs with other tolerances; the controller's model is the nominal machine in all.

    Args:
        machine: nominal machine.
        step: step of a joint.
        tolerances: ranges of the values that vary; None for the defaults.
        runs: number of runs, a power of two.
        overtaken: called from time to time; True ends the simulation.

    Raises:
        InputError: the machine lacks controller or valve, the step leaves the joint's stroke, or has more control
            cycles than `MAX_CYCLES`.
        OvertakenError: `overtaken` returned True.
    """
    if machine.controller is None or machine.valve is None:
        right = "open a machine with a valve and a controller to see its step response"
        missing = "controller" if machine.controller is None else "valve"
        raise MachineError(f"has no {missing}", where=machine.origin, right=right)

    scenario = step_scenario(machine, step)
    if scenario.cycles(machine.cycle) > MAX_CYCLES:
        right = f"give a shorter time, or a cycle of at least {1e3 * (STEP_DELAY + step.duration) / MAX_CYCLES:.2g} ms"
        problem = f"has {scenario.cycles(machine.cycle)} control cycles, more than {MAX_CYCLES}"
        raise InputError(problem, where="step response", right=right)

    def go_on(_done: int) -> None:
        if overtaken():
            raise OvertakenError

    start = time.perf_counter()
    plant_step = STEP if len(machine.joints) <= MAX_FINE_JOINTS else COARSE_STEP
    results = ensemble(
        machine, scenario, vary_parameters(machine, tolerances or Tolerances(), runs), controller=machine,
        step=plant_step, traces=SIGNALS, every=CYCLES_PER_RECORD, progress=go_on,
    ).sel(joint=step.joint)  # fmt: skip
    metrics = results.isel(move=-1)
    traces = {name: results[name].to_numpy() for name in SIGNALS}
    return StepCloud(
        step, results["time"].to_numpy() - STEP_DELAY, **traces, settling=metrics["settling"].to_numpy(),
        overshoot=metrics["overshoot"].to_numpy(), air=results["air_used"].to_numpy(),
        hysteresis=float(results["hysteresis"][0]), plant_step=plant_step, seconds=time.perf_counter() - start,
    )  # fmt: skip
