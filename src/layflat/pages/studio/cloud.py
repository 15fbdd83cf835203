"""The step response of a joint as a cloud of runs over tolerances and payloads: an `ensemble` that keeps traces."""

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
from layflat.pages.studio.results import Quantity
from layflat.physics.step import COARSE, STEP
from layflat.sim.ensemble import ensemble
from layflat.sim.metrics import BAND

RUNS = 256  # a power of two, as Sobol's points want
REST = 0.1  # time before the step, s
MOST_CYCLES = 4000  # of a run: sensor noise of all runs is in memory at once
EVERY = 4  # control cycles from one record to the next
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
SINGLE = 6  # runs that are drawn one by one
FEW = 2  # joints up to which runs take the default step; those of more take the coarse one, as tuning searches


class OvertakenError(Exception):
    """A newer design is to be simulated."""


@dataclass(frozen=True)
class Tolerances:
    """Spread of runs: shares either way, and payloads from none to a share of the described one."""

    valve: float = 0.1
    friction: float = 0.2
    supply: float = 0.1
    losses: float = 0.3
    payload: float = 1.0


@dataclass(frozen=True)
class Step:
    """A step of one joint about mid-stroke, where the others rest."""

    joint: str
    size: float = radians(40.0)  # rad
    lasts: float = 1.5  # s, from the step on


@dataclass(frozen=True)
class Cloud:
    """Runs of a step, the first of them nominal; arrays are (runs,) or (runs, instants)."""

    step: Step
    time: Array  # s, from the step on, (instants,)
    angle: Array  # rad
    pressure_a: Array  # absolute, Pa
    pressure_b: Array
    settling: Array  # s; infinite where it does not settle, not a number where the run diverged
    overshoot: Array  # rad
    air: Array  # normal litres of all joints
    hysteresis: float  # nominal, share
    plant_step: float  # s
    seconds: float  # that it took

    @property
    def runs(self) -> int:
        """Return how many there are."""
        return len(self.settling)

    @cached_property
    def sound(self) -> NDArray[np.bool_]:
        """Return which runs did not diverge."""
        return np.isfinite(self.overshoot)

    def levels(self, of: Array) -> Array:
        """Return the quantiles `LEVELS` of a signal over all runs that did not diverge, (levels, instants)."""
        return np.asarray(np.quantile(of[self.sound], LEVELS, axis=0))

    @cached_property
    def angle_levels(self) -> Array:
        """Quantiles of the angle, (levels, instants), rad."""
        return self.levels(self.angle)

    @cached_property
    def pressure_a_levels(self) -> Array:
        """Quantiles of the pressure of hose A, (levels, instants), Pa."""
        return self.levels(self.pressure_a)

    @cached_property
    def pressure_b_levels(self) -> Array:
        """Quantiles of the pressure of hose B, (levels, instants), Pa."""
        return self.levels(self.pressure_b)

    def rank(self) -> Self:
        """Find all quantiles, so that who is given this cloud has them; they take long. Return the cloud."""
        if self.sound.any():
            _ = self.angle_levels, self.pressure_a_levels, self.pressure_b_levels
        return self

    def settled(self, share: float) -> float:
        """Return the time in which a share of all runs have settled, s; infinite where fewer do."""
        known = np.sort(np.where(self.sound, self.settling, np.inf))
        return float(known[min(len(known) - 1, int(np.ceil(share * len(known))) - 1)])

    @property
    def late(self) -> int:
        """Return how many runs have not settled by the end."""
        return int(np.sum(~np.isfinite(self.settling)))

    @property
    def diverged(self) -> int:
        """Return how many runs diverged."""
        return int(np.sum(~self.sound))

    @property
    def quantities(self) -> list[Quantity]:
        """Return what is compared between designs."""
        return [
            Quantity("settled, half of all runs", self.settled(0.5), "s", 3),
            Quantity("settled, 95 % of all runs", self.settled(0.95), "s", 3),
            Quantity("runs that do not settle", float(self.late), f"of {self.runs}", 3),
            Quantity("overshoot, nominal", float(np.degrees(self.overshoot[0])), "deg", 2),
            Quantity("air of the move, nominal", float(self.air[0]), "normal l", 3),
            Quantity("hysteresis, brake on", 100 * self.hysteresis, "%", 3),
        ]

    @property
    def summary(self) -> str:
        """Return how soon it settles, in a sentence."""
        band = f"within {np.degrees(BAND):.2g} deg"
        shares = [f"{100 * share:.0f} % in {self.settled(share):.2f} s" for share in LEVELS[2:]
                  if np.isfinite(self.settled(share))]  # fmt: skip
        text = f"Settled {band}: {', '.join(shares)}." if shares else f"Fewer than half of the runs settle {band}."
        if self.late:
            text += f" {self.late} of {self.runs} runs do not settle in {self.step.lasts:g} s."
        return text + (f" {self.diverged} runs diverged and are not drawn." if self.diverged else "")


def usual_step(machine: Machine) -> Step:
    """Return the step that is looked at first: of the joint at the base, shorter where it takes long to simulate."""
    lasts = Step.lasts if len(machine.joints) <= FEW else 0.8
    return Step(next(iter(machine.joints)), lasts=lasts)


def scenario(machine: Machine, step: Step) -> Scenario:
    """Return the step as what happens to a machine."""
    half = step.size / 2
    before, after = ({**dict.fromkeys(machine.joints, 0.0), step.joint: way * half} for way in (-1.0, 1.0))
    return Scenario(demand=[(0.0, before), (REST, after)], duration=REST + step.lasts)


def varied(machine: Machine, tolerances: Tolerances, runs: int) -> dict[str, Array]:
    """Return what differs from run to run, by path; the first run is nominal, and the runs fill all ranges evenly."""
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
        for part, usual in (("hose", joint.hose.loss_share), ("strap", joint.strap.loss_share)):
            shares = usual * (1.0 + tolerances.losses * about[:, 3])
            vary[f"joint.{name}.{part}.loss_share"] = np.minimum(shares, 1.0)
    return vary


def cloud(
    machine: Machine, step: Step, tolerances: Tolerances | None = None, *, runs: int = RUNS,
    overtaken: Callable[[], bool] = lambda: False,
) -> Cloud:  # fmt: skip
    """Simulate a step with all tolerances; controllers know the nominal machine only.

    Args:
        machine: which is nominal.
        step: what the joint does.
        tolerances: how far runs differ.
        runs: a power of two.
        overtaken: is asked from time to time whether the result is still wanted.

    Raises:
        InputError: the machine can't be simulated, or the step leaves the joint's stroke.
        OvertakenError: the result is not wanted any more.
    """
    if machine.controller is None or machine.valve is None:
        right = "open a machine with a valve and a controller to see its step response"
        raise MachineError("has no controller", where=machine.origin, right=right)

    what = scenario(machine, step)
    if what.cycles(machine.cycle) > MOST_CYCLES:
        right = f"give a shorter time, or a cycle of at least {1e3 * (REST + step.lasts) / MOST_CYCLES:.2g} ms"
        raise InputError("has too many control cycles to show at once", where="step response", right=right)

    def go_on(_done: int) -> None:
        if overtaken():
            raise OvertakenError

    begun = time.perf_counter()
    plant_step = STEP if len(machine.joints) <= FEW else COARSE
    found = ensemble(
        machine, what, varied(machine, tolerances or Tolerances(), runs), controller=machine,
        step=plant_step, traces=("angle", "pressure_a", "pressure_b"), every=EVERY, progress=go_on,
    ).sel(joint=step.joint)  # fmt: skip
    metrics = found.isel(move=-1)
    traces = {name: found[name].to_numpy() for name in ("angle", "pressure_a", "pressure_b")}
    return Cloud(
        step, found["time"].to_numpy() - REST, **traces, settling=metrics["settling"].to_numpy(),
        overshoot=metrics["overshoot"].to_numpy(), air=found["air_used"].to_numpy(),
        hysteresis=float(found["hysteresis"][0]), plant_step=plant_step, seconds=time.perf_counter() - begun,
    )  # fmt: skip
