"""Axis one: the small joint alone with and without its brake, against the earlier actuator (Fig. 13)."""

from dataclasses import replace
from functools import cached_property
from itertools import takewhile
from math import inf, radians

import numpy as np
import xarray

from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque, payload_for_inertia
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.machine import Machine
from layflat.sim import Scenario
from layflat.sim.metrics import BAND, move, settling_time
from layflat.sim.run import Prepared, prepare, rollout_as_far

STEP = radians(40)
AT = 0.5  # the step comes at this time, s, after the joint has come to rest
DURATION, SCAN = 8.0, 4.0
"""How long a joint is watched after the step, s: in the runs that are shown, and when its limit is sought."""
GOOD_TIME = 1.5  # a joint carries an inertia if it settles within this time, s: what the paper gives for the arm
SEEDS = 5  # runs with other noise at each inertia; their median counts
RATIOS = tuple(float(ratio) for ratio in np.geomspace(INERTIA_PER_TORQUE, 1e-1, 25))
"""Inertia per torque over which the limit is sought, from the paper's comparison on, kg m2 per N m."""
PER_TORQUE = "kg m2/(N m)"


def _case(payload: float, brake: float, duration: float, seed: int) -> Scenario:
    """A joint that rests at -20 deg and is asked for +20 deg."""
    demand: list[tuple[str | float, float]] = [(0.0, -STEP / 2), (AT, STEP / 2)]
    return Scenario(demand=demand, duration=AT + duration, payload=payload, brake=brake, seed=seed)


def settling(run: xarray.Dataset) -> float:
    """Return the time from the step until the joint stays within 0.3 deg of its demand, s."""
    if float(run["time"][-1]) < AT + 1.0:
        return inf
    return move(run, "small", since=AT).settling


def settling_times(machine: Machine, brake: float) -> dict[float, float]:
    """Return settling times (s) by inertia per torque, kg m2 per N m."""
    torque = maximum_torque(machine, "small")
    payloads = {ratio: payload_for_inertia(machine, "small", ratio * torque) for ratio in RATIOS}
    runs = [prepare(machine, _case(0.0, brake, SCAN, seed)) for seed in range(SEEDS)]
    return {ratio: float(np.median([_settled(run, payload) for run in runs])) for ratio, payload in payloads.items()}


def limit_within(times: dict[float, float], allowed: float) -> float:
    """Return the largest inertia per torque up to which all settle within the time allowed (s); 0 where none does."""
    return max((ratio for ratio, _ in takewhile(lambda found: found[1] <= allowed, times.items())), default=0.0)


def _settled(prepared: Prepared, payload: float) -> float:
    """Settling time of a prepared step with another payload (kg), s."""
    signals = prepared.signals._replace(payload=np.full_like(prepared.signals.payload, payload))
    rows, _, diverged = replace(prepared, signals=signals).run()
    cycle = prepared.timing.cycle
    error = rows[round(AT / cycle) :, 0, 0] - STEP / 2
    return inf if diverged >= 0 else settling_time(cycle * np.arange(len(error)), error, BAND)


class AxisOne(Experiment):
    """Runs of a 40 deg step, and the settling times of both joints by the inertia per torque that they carry."""

    def _step(self, machine: Machine, brake: float, payload: float | None = None) -> xarray.Dataset:
        """A step, up to where it diverged if it did; usually at the inertia per torque of the paper's comparison."""
        inertia = INERTIA_PER_TORQUE * maximum_torque(machine, "small")
        carried = payload_for_inertia(machine, "small", inertia) if payload is None else payload
        return rollout_as_far(machine, scenario=_case(carried, brake, DURATION, seed=1))

    @cached_property
    def unbraked(self) -> xarray.Dataset:
        """The new joint without brake."""
        return self._step(self.bench.axis_one, 0.0)

    @cached_property
    def earlier(self) -> xarray.Dataset:
        """The earlier actuator."""
        return self._step(self.bench.earlier_scaled, 0.0)

    @cached_property
    def braked(self) -> xarray.Dataset:
        """The new joint with its brake and the paper's 2 kg."""
        return self._step(self.bench.axis_one, self.bench.brake, self.bench.axis_one.arm.payload)

    @cached_property
    def times_braked(self) -> dict[float, float]:
        """Settling times of the new joint with its brake, s, by inertia per torque."""
        return settling_times(self.bench.axis_one, self.bench.brake)

    @cached_property
    def times_earlier(self) -> dict[float, float]:
        """The same of the earlier actuator."""
        return settling_times(self.bench.earlier_scaled, 0.0)

    @claim("unbraked-joint")
    def unbraked_joint(self) -> Evaluated:
        """Compare both joints without brake."""
        new, earlier = settling(self.unbraked), settling(self.earlier)
        reach = float(np.degrees(np.abs(self.unbraked["angle"]).max()))
        whole = float(self.unbraked["time"][-1]) >= AT + DURATION - 0.01
        return [
            Quantity("new joint settles in", new, "s", "several seconds"),
            Quantity("earlier actuator settles in", earlier, "s", "good"),
        ], whole and reach <= 70.0 and new > 2.0 and 2.0 * earlier <= new and earlier < inf

    @claim("braked-joint")
    def braked_joint(self) -> Evaluated:
        """Settle with the brake, and compare the greatest inertias that settle."""
        time = settling(self.braked)
        last = self.braked["angle"].sel(time=slice(AT + DURATION - 2.0, None))
        calm = float(last.max() - last.min()) <= BAND
        braked, earlier = (limit_within(times, GOOD_TIME) for times in (self.times_braked, self.times_earlier))
        late_braked, late_earlier = (limit_within(times, SCAN) for times in (self.times_braked, self.times_earlier))
        ratio = braked / earlier if earlier > 0.0 else inf
        return [
            Quantity("settling", time, "s", "stable"),
            Quantity("limit with brake", braked, PER_TORQUE),
            Quantity("limit of earlier", earlier, PER_TORQUE),
            Quantity("ratio", ratio, paper="about 2"),
            Quantity("ratio if 4 s are allowed", late_braked / late_earlier if late_earlier > 0.0 else inf),
        ], time < inf and calm and earlier > 0.0 and ratio >= 1.6
