"""Axis one: the small joint alone with and without its brake, against the earlier actuator (Fig. 13)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, radians
from typing import TYPE_CHECKING

import numpy as np

from layflat.errors import DivergedError
from layflat.experiments.bench import INERTIA_PER_TORQUE, Bench, maximum_torque, payload_for_inertia
from layflat.experiments.claim import Claim
from layflat.machine import Machine
from layflat.sim import Scenario, rollout
from layflat.sim.metrics import BAND, move, settling_time
from layflat.sim.run import Prepared, prepare

if TYPE_CHECKING:
    import xarray

STEP = radians(40)
AT = 0.5
"""The step comes at this time, s, after the joint has come to rest."""
DURATION, SCAN = 8.0, 4.0
"""How long a joint is watched after the step, s: in the runs that are shown, and when its limit is sought."""
GOOD_TIME = 1.5
"""A joint carries an inertia if it settles within this time, s: what the paper gives for the arm."""
SEEDS = 5
"""Runs with other noise at each inertia; their median counts."""
RATIOS = tuple(float(ratio) for ratio in np.geomspace(INERTIA_PER_TORQUE, 1e-1, 25))
"""Inertia per torque over which the limit is sought, from the paper's comparison on, kg m2 per N m."""


@dataclass(frozen=True)
class AxisOne:
    """Runs of a 40 deg step, and the largest inertia per torque (kg m2 per N m) that each joint settles."""

    unbraked: xarray.Dataset
    earlier: xarray.Dataset
    braked: xarray.Dataset
    limit_braked: float
    limit_earlier: float
    settling_braked: dict[float, float]
    settling_earlier: dict[float, float]


def _case(payload: float, brake: float, duration: float, seed: int) -> Scenario:
    """A joint that rests at -20 deg and is asked for +20 deg."""
    demand: list[tuple[str | float, float]] = [(0.0, -STEP / 2), (AT, STEP / 2)]
    return Scenario(demand=demand, duration=AT + duration, payload=payload, brake=brake, seed=seed)


def step_run(machine: Machine, payload: float, brake: float) -> xarray.Dataset:
    """The step as a run, up to where it diverged if it did."""
    try:
        return rollout(machine, scenario=_case(payload, brake, DURATION, seed=1))
    except DivergedError as error:
        return error.run  # type: ignore[return-value]


def settling(run: xarray.Dataset) -> float:
    """Time from the step until the joint stays within 0.3 deg of its demand, s."""
    if float(run["time"][-1]) < AT + 1.0:
        return inf
    return move(run, "small", since=AT).settling


def stability(machine: Machine, brake: float) -> tuple[float, dict[float, float]]:
    """Largest inertia per torque up to which every one settles in good time; all settling times (s)."""
    torque = maximum_torque(machine, "small")
    runs = [prepare(machine, _case(0.0, brake, SCAN, seed)) for seed in range(SEEDS)]
    times: dict[float, float] = {}
    for ratio in RATIOS:
        payload = payload_for_inertia(machine, "small", ratio * torque)
        times[ratio] = float(np.median([_settled(run, payload) for run in runs]))
    return limit_within(times, GOOD_TIME), times


def limit_within(times: dict[float, float], allowed: float) -> float:
    """Largest inertia per torque up to which every one settles within the time allowed (s); 0 where none does."""
    limit = 0.0
    for ratio, time in times.items():
        if time > allowed:
            break
        limit = ratio
    return limit


def _settled(prepared: Prepared, payload: float) -> float:
    """Settling time of a prepared step with another payload (kg), s."""
    signals = prepared.signals._replace(payload=np.full_like(prepared.signals.payload, payload))
    rows, diverged = replace(prepared, signals=signals).run()
    cycle = prepared.timing.cycle
    error = rows[round(AT / cycle) :, 0, 0] - STEP / 2
    return inf if diverged >= 0 else settling_time(cycle * np.arange(len(error)), error, BAND)


def perform(bench: Bench) -> AxisOne:
    """Step the joints at the same inertia per torque, then look how much inertia each can carry."""

    def comparable(machine: Machine) -> float:
        return payload_for_inertia(machine, "small", INERTIA_PER_TORQUE * maximum_torque(machine, "small"))

    new, earlier = bench.axis_one, bench.earlier_scaled
    limit_braked, times_braked = stability(new, bench.brake)
    limit_earlier, times_earlier = stability(earlier, 0.0)
    return AxisOne(
        step_run(new, comparable(new), 0.0),
        step_run(earlier, comparable(earlier), 0.0),
        step_run(new, new.arm.payload, bench.brake),
        limit_braked,
        limit_earlier,
        times_braked,
        times_earlier,
    )


def claims(runs: AxisOne) -> list[Claim]:
    """What the paper says of axis one."""
    return [_unbraked(runs), _braked(runs)]


def _unbraked(runs: AxisOne) -> Claim:
    new, earlier = settling(runs.unbraked), settling(runs.earlier)
    reach = float(np.degrees(np.abs(runs.unbraked["angle"]).max()))
    whole = float(runs.unbraked["time"][-1]) >= AT + DURATION - 0.01
    return Claim(
        "unbraked-joint",
        "4.1",
        "without brake the new joint is stable but takes several seconds and oscillates a little; the earlier is good",
        {"new": new, "earlier": earlier},
        "s to settle within 0.3 deg (none: not in 8 s)",
        whole and reach <= 70.0 and new > 2.0 and 2.0 * earlier <= new and earlier < inf,
        "bounded, over 2 s; the earlier actuator settles at least twice as fast",
    )


def _braked(runs: AxisOne) -> Claim:
    time = settling(runs.braked)
    last = runs.braked["angle"].sel(time=slice(AT + DURATION - 2.0, None))
    calm = float(last.max() - last.min()) <= BAND
    ratio = runs.limit_braked / runs.limit_earlier if runs.limit_earlier > 0.0 else inf
    late_braked, late_earlier = (limit_within(t, SCAN) for t in (runs.settling_braked, runs.settling_earlier))
    late = late_braked / late_earlier if late_earlier > 0.0 else inf
    return Claim(
        "braked-joint",
        "4.1, Fig. 13",
        "stable with the brake at 0.32 kg m2, about twice the earlier actuator's limit relative to torque",
        {
            "settling (s)": time,
            "limit with brake": runs.limit_braked,
            "limit of earlier": runs.limit_earlier,
            "ratio": ratio,
            "ratio if 4 s are allowed": late,
        },
        "kg m2 per N m, unless said",
        time < inf and calm and runs.limit_earlier > 0.0 and ratio >= 1.6,
        "settles within 0.3 deg without sustained oscillation; ratio of limits (settled in 1.5 s) at least 1.6",
    )
