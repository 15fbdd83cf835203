"""Axis one: the small joint alone with and without its brake, its inertia, and the earlier actuator (Fig. 13)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import takewhile
from math import inf, radians

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.description import units as u
from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque, payload_for_inertia
from layflat.experiments.claim import ClaimQuantity, Evaluation, Experiment, claim
from layflat.machine import Machine
from layflat.motion.scenario import Scenario
from layflat.sim.ensemble.parallel import simulate_traces
from layflat.sim.metrics import SETTLING_BAND, measure_move, settling_time
from layflat.sim.signals import expand_scenario

STEP = radians(40)
STEP_TIME = 0.5  # of the demand's step, s; by then the joint is at rest
DURATION = 12.0  # simulated time after the step, s
SEED_COUNT = 5  # noise seeds simulated at each inertia, whose median counts
INERTIA_RATIOS = tuple(float(ratio) for ratio in np.geomspace(INERTIA_PER_TORQUE, 1e-1, 25))
"""Inertia per torque, kg m2 per N m, from the paper's comparison upwards: each is simulated in a search for limits."""
SETTLING_LIMITS = (1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # upper limits of the settling time, s
OSCILLATION_WINDOW = 2.0  # over which peak to peak is measured, s
FADING_RATIO = 0.8  # an oscillation below this fraction of that in the window before is not sustained


def step_scenario(brake: float, seed: int, payload: float | None = None) -> Scenario:
    """Return the scenario of a step from rest at -20 deg to +20 deg.

    Args:
        brake: torque of the brake, as a fraction of its full torque.
        seed: seed of the noise.
        payload: kg; default: the machine's.
    """
    demand: list[tuple[str | float, float]] = [(0.0, -STEP / 2), (STEP_TIME, STEP / 2)]
    return Scenario(demand=demand, duration=STEP_TIME + DURATION, payload=payload, brake=brake, seed=seed)


def oscillation(time: Array, angle: Array) -> tuple[float, float]:
    """Return the peak-to-peak angle over the last two seconds and over the two before, in the unit of `angle`."""
    last, before = (
        time > time[-1] - OSCILLATION_WINDOW,
        (time > time[-1] - 2 * OSCILLATION_WINDOW) & (time <= time[-1] - OSCILLATION_WINDOW),
    )
    return float(np.ptp(angle[last])), float(np.ptp(angle[before]))


def is_sustained(time: Array, angle: Array) -> bool:
    """Return whether an angle (rad) oscillates at the end by more than +-`SETTLING_BAND`, and does not fade."""
    last, before = oscillation(time, angle)
    return not (last <= 2.0 * SETTLING_BAND or last < FADING_RATIO * before)


def max_settling_inertia(times: Mapping[float, float], allowed: float) -> float:
    """Return the largest inertia per torque up to which all settle within the allowed time (s); 0 where none does.

    `times` are settling times (s) by inertia per torque, which rises.
    """
    return max((ratio for ratio, _ in takewhile(lambda pair: pair[1] <= allowed, times.items())), default=0.0)


def trace_rollout(machine: Machine, scenario: Scenario) -> xarray.Dataset:
    """Return demands and angles (rad) of a rollout, up to where it diverged, computed by the ensemble's kernel.

    `sweep_inertia` has that kernel compiled in any case, and its runs are rollouts to the last bit.
    """
    # A run ends with a record, a trace with the cycle before.
    longer = replace(scenario, duration=u.quantity(scenario.duration, u.TIME, "duration") + machine.cycle)
    angle = simulate_traces(machine, longer, {}, ("angle",))[0, :, :, 0]
    sound = ~np.isnan(angle).any(axis=1)
    demand = expand_scenario(longer, machine, machine.cycle).named("demand")
    return xarray.Dataset(
        {"demand": (("time", "joint"), demand[sound]), "angle": (("time", "joint"), angle[sound])},
        {"time": machine.cycle * np.arange(len(angle))[sound], "joint": list(machine.joints)},
    )


@dataclass(frozen=True)
class InertiaSweep:
    """Settling of a joint by inertia per torque (kg m2 per N m), as the median over noise seeds."""

    times: Mapping[float, float]  # settling time to 0.3 deg, s; infinite: never
    sustained: Mapping[float, bool]  # True where an oscillation is sustained

    def max_inertia_within(self, allowed: float) -> float:
        """Return the largest inertia per torque up to which all settle within the allowed time (s); 0: none does."""
        return max_settling_inertia(self.times, allowed)

    @property
    def stable(self) -> float:
        """The largest inertia per torque up to which no oscillation is sustained; 0: even the least has one."""
        return max_settling_inertia({ratio: inf if swings else 0.0 for ratio, swings in self.sustained.items()}, 0.0)


def sweep_inertia(machine: Machine, brake: float) -> InertiaSweep:
    """Return the settling of steps of the small joint at each of `INERTIA_RATIOS`, medians over `SEED_COUNT` seeds.

    `brake` is a fraction of the brake's full torque.
    """
    torque = maximum_torque(machine, "small")
    payloads = [payload_for_inertia(machine, "small", ratio * torque) for ratio in INERTIA_RATIOS]
    vary = {
        "arm.payload": np.repeat(payloads, SEED_COUNT),
        "seed": np.tile(np.arange(SEED_COUNT, dtype=float), len(INERTIA_RATIOS)),
    }
    angles = simulate_traces(machine, step_scenario(brake, 0), vary, ("angle",))[:, :, 0, 0]
    first_cycle = round(STEP_TIME / machine.cycle)
    time = machine.cycle * np.arange(angles.shape[1] - first_cycle)
    outcomes = np.array([_settling_and_oscillation(time, error) for error in angles[:, first_cycle:] - STEP / 2])
    times, sustained = np.median(outcomes.reshape(len(INERTIA_RATIOS), SEED_COUNT, 2), axis=1).T.tolist()
    return InertiaSweep(
        dict(zip(INERTIA_RATIOS, times, strict=True)), dict(zip(INERTIA_RATIOS, map(bool, sustained), strict=True))
    )


def _settling_and_oscillation(time: Array, error: Array) -> tuple[float, bool]:
    """Return settling time (s; infinite: never), and whether an oscillation is sustained, of an error (rad).

    NaN in the error, of a joint that diverges, gives infinite and True.
    """
    if np.isnan(error).any():
        return inf, True
    return settling_time(time, error, SETTLING_BAND), is_sustained(time, error)


SETTLING_GOAL = 1.5  # settling time that the paper gives for the arm, s
LONG_SETTLING_LIMIT = 4.0  # second, longer limit of the settling time, s
ARRIVAL_BAND = radians(1.5)  # about the mean final angle, wide enough for a small oscillation
SMALL_OSCILLATION = radians(1.0)  # upper limit, peak to peak
GROWTH_RATIO, GROWTH_TOLERANCE = 1.1, radians(0.1)  # a growing oscillation is larger than ratio x before + tolerance
SEVERAL_SECONDS = (2.0, 8.0)  # range of "several seconds", s
ABOUT_TWICE = (1.4, 2.8)  # range of "about twice"
INERTIA_RATIO_UNIT = "kg m2/(N m)"


def step_settling(run: xarray.Dataset) -> float:
    """Return the time from the step until the small joint stays within 0.3 deg, s; infinite if never, or diverged."""
    if not _is_complete(run):
        return inf
    return measure_move(run, "small", since=STEP_TIME).settling


def _is_complete(run: xarray.Dataset) -> bool:
    return float(run["time"][-1]) >= STEP_TIME + DURATION - 0.01


def _step_response(run: xarray.Dataset) -> tuple[Array, Array]:
    """Return time since the step (s) and angle (rad) of the small joint."""
    part = run.sel(joint="small", time=slice(STEP_TIME, None))
    return part["time"].to_numpy() - STEP_TIME, part["angle"].to_numpy()


class AxisOneExperiment(Experiment):
    """Runs of a 40 deg step of both joints, and their settling with every inertia per torque."""

    def _step(self, machine: Machine, brake: float, payload: float | None = None) -> xarray.Dataset:
        """Return a step, up to where it diverged, by fraction of the brake and payload (kg).

        Default payload: that with the paper's inertia per torque.
        """
        inertia = INERTIA_PER_TORQUE * maximum_torque(machine, "small")
        load = payload_for_inertia(machine, "small", inertia) if payload is None else payload
        return trace_rollout(machine, step_scenario(brake, 1, load))

    @cached_property
    def unbraked(self) -> xarray.Dataset:
        """Step of the new joint without brake, at the paper's inertia per torque."""
        return self._step(self.bench.axis_one, 0.0)

    @cached_property
    def earlier(self) -> xarray.Dataset:
        """Step of the earlier actuator, at the paper's inertia per torque."""
        return self._step(self.bench.earlier_scaled, 0.0)

    @cached_property
    def braked(self) -> xarray.Dataset:
        """Step of the new joint with its brake and the paper's 2 kg."""
        return self._step(self.bench.axis_one, self.bench.brake, self.bench.axis_one.arm.payload)

    @cached_property
    def carried_braked(self) -> InertiaSweep:
        """Settling of the new joint with its brake, by inertia."""
        return sweep_inertia(self.bench.axis_one, self.bench.brake)

    @cached_property
    def carried_earlier(self) -> InertiaSweep:
        """Settling of the earlier actuator, by inertia."""
        return sweep_inertia(self.bench.earlier_scaled, 0.0)

    @claim("unbraked-joint")
    def unbraked_joint(self) -> Evaluation:
        """Measure arrival, oscillation and overshoot of the new joint without brake, and settling of the earlier."""
        if not _is_complete(self.unbraked):
            return [ClaimQuantity("diverged after", float(self.unbraked["time"][-1]) - STEP_TIME, "s")], False
        time, angle = _step_response(self.unbraked)
        last, before = oscillation(time, angle)
        arrives = settling_time(time, angle - angle[time > time[-1] - OSCILLATION_WINDOW].mean(), ARRIVAL_BAND)
        overshoot, earlier = float(angle.max()) - STEP / 2, step_settling(self.earlier)
        small_oscillation = (
            last <= SMALL_OSCILLATION and last <= GROWTH_RATIO * before + GROWTH_TOLERANCE and overshoot <= STEP / 2
        )
        return [
            ClaimQuantity("new joint arrives in", arrives, "s", "several seconds"),
            ClaimQuantity("oscillation left", float(np.degrees(last)), "deg", "small"),
            ClaimQuantity("overshoot", float(np.degrees(overshoot)), "deg"),
            ClaimQuantity("earlier actuator settles in", earlier, "s", "good"),
        ], small_oscillation and SEVERAL_SECONDS[0] <= arrives <= SEVERAL_SECONDS[1] and 2.0 * earlier <= arrives

    @claim("braked-joint")
    def braked_joint(self) -> Evaluation:
        """Measure settling with the brake, and ratios of the greatest inertias that settle, new over earlier joint."""
        time, stationary = step_settling(self.braked), not is_sustained(*_step_response(self.braked))
        new, earlier = self.carried_braked, self.carried_earlier
        pairs = {
            f"within {allowed:g} s": (new.max_inertia_within(allowed), earlier.max_inertia_within(allowed))
            for allowed in SETTLING_LIMITS
        }
        pairs["without sustained oscillation"] = new.stable, earlier.stable
        ratios = {name: ours / theirs if theirs > 0.0 else inf for name, (ours, theirs) in pairs.items()}
        return [
            ClaimQuantity("settling", time, "s", "stable"),
            ClaimQuantity("limit with brake", new.stable, INERTIA_RATIO_UNIT),
            ClaimQuantity("limit of earlier", earlier.stable, INERTIA_RATIO_UNIT),
            *(ClaimQuantity(f"ratio {name}", ratio, paper="about 2") for name, ratio in ratios.items()),
        ], time < inf and stationary and all(ABOUT_TWICE[0] <= ratio <= ABOUT_TWICE[1] for ratio in ratios.values())
