"""Lower bound of a step's settling time: valve openings that are optimized offline on the whole simulated plant.

It bounds any controller, as closely as a search can: no controller of the same valves knows more. The
openings are optimized on the simulated plant itself, with its valves, air, friction and hysteresis. The search
begins with the tracking law's openings, and with the best of many that accelerate, brake, and release.
"""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from layflat.arrays import Array, Dataset
from layflat.description import units as u
from layflat.errors import UnreachedError
from layflat.experiments.beyond.search import (
    LATE_CYCLES,
    REST_CYCLES,
    TAIL_CYCLES,
    OpeningTrial,
    Shooting,
    minimize_cycles,
    reach_band,
    settling_cycles,
    simulate_trial,
    sum_excess,
)
from layflat.machine import Machine, changed
from layflat.machine.exchanged import with_tracking
from layflat.motion.scenario import Scenario
from layflat.motion.signal_values import Angles, Value
from layflat.sim import rollout
from layflat.sim.metrics import TIP_BAND, tip_settling
from layflat.sim.run import start_angles

SAMPLE_COUNT = 1024  # of switching openings; a power of two, for the Sobol sequence
MIN_OPENING = 0.3  # of sampled openings, fraction of full opening
REST_DURATION, STEP_DURATION = 0.5, 2.0  # of the tracking law's run, before and after the step, s
MIN_STAY_CYCLES = 40  # control cycles that the law has to stay at the goal


class TrackedStep(NamedTuple):
    """Run of the tracking law: openings (cycles, joints), and the cycles until the tip stays in its band."""

    openings: Array
    cycles: int


def simulate_tracking_law(shooting: Shooting, band: float) -> TrackedStep | None:
    """Return the tracking law's step without noise; None where it can't model the machine or does not settle.

    Args:
        shooting: the step.
        band: distance of the tip from its goal within which it has to stay, m.
    """
    machine = with_tracking(shooting.machine)
    if machine is None or machine.valve is None:
        return None
    demand = [(0.0, list(shooting.start)), (REST_DURATION, list(shooting.end))]
    run = rollout(machine, demand, duration=REST_DURATION + STEP_DURATION, noise=False)
    begins = round(REST_DURATION / machine.cycle)
    cycles = int(settling_cycles(run["tip"].to_numpy()[begins + 1 :] - shooting.goal, band))
    voltage = run["voltage"].to_numpy()[begins:-1]
    openings = np.clip((voltage - machine.valve.centre_voltage) / machine.valve.volts_to_full, -1.0, 1.0)
    return TrackedStep(openings, cycles) if cycles < len(openings) - MIN_STAY_CYCLES else None


def best_switching_openings(shooting: Shooting, cycles: int, band: float, seed: int) -> Array:
    """Return the best of many openings that accelerate, brake, and release, (cycles and a tail, joints).

    Args:
        shooting: the step.
        cycles: after which the tip is to stay in its band.
        band: m.
        seed: seed of the sample.
    """
    joints = len(shooting.start)
    directions = np.sign(np.round(np.subtract(shooting.end, shooting.start), 6))
    draws = qmc.Sobol(7 * joints, seed=seed).random(SAMPLE_COUNT).reshape(SAMPLE_COUNT, 7, joints)
    # A joint that is to stay has to be held against the other's motion, in either direction.
    sides = np.where(directions == 0.0, np.sign(draws[:, 0] - 0.5), directions)
    switch_times = np.sort(draws[:, 1:4], axis=1) * (cycles + LATE_CYCLES)
    sizes = MIN_OPENING + (1.0 - MIN_OPENING) * draws[:, 4:]
    openings = np.zeros((SAMPLE_COUNT, cycles + TAIL_CYCLES, joints))
    start_times, k = np.zeros((SAMPLE_COUNT, joints)), np.arange(cycles + TAIL_CYCLES)[None, :, None]
    for i, sign in enumerate((1.0, -1.0, 1.0)):
        # A switch within a cycle holds for its fraction of it.
        duty = np.clip(switch_times[:, None, i] - k, 0.0, 1.0) - np.clip(start_times[:, None] - k, 0.0, 1.0)
        openings += sign * (sides * sizes[:, i])[:, None] * duty
        start_times = switch_times[:, i]
    best: Array = openings[np.argmin(sum_excess(shooting.errors(openings), cycles, band))]
    return best


RESTART_SEEDS = (0, 1)  # of the samples with which the search begins again
HOLD_TIME = 1.0  # for which the tip has to stay within its band, s
FIRST_CYCLES, MAX_CYCLES = 20, 640  # least and most cycles that are tried where the tracking law does not settle


@dataclass(frozen=True)
class Optimum:
    """Fastest step of the search.

    Args:
        settling: time from the step until the tip stays within its band to the end, s.
        openings: openings of the valves from the step on, -1..1, (cycles, joints).
        run: the step, from rest on and until the tip has stayed for a second.
        step_time: time in `run` at which the step begins, s.
    """

    settling: float
    openings: Array
    run: Dataset
    step_time: float


def settling_bound(
    machine: Machine, start: Angles, end: Angles, *, payload: Value | None = None, band: Value = TIP_BAND
) -> Optimum:
    """Search for the least settling time of a step with all of the plant known and without noise.

    The arm is at rest at first; the valves are driven in open loop, by an opening for each control cycle. The search
    begins with the tracking law's openings, where the machine can have that law, and with switching ones; the best
    result counts. It is deterministic. Times are whole control cycles. The returned openings reach the returned time;
    faster ones may exist: searches from other initial openings end one or two cycles apart, seldom more.

    The hoses begin with what equal leakage leaves in them, which bears no gravity: the arm has to be level.

    Args:
        machine: machine whose plant is simulated; only the period of its controller is used.
        start: angles at which the arm rests at first.
        end: angles whose tip is the goal.
        payload: default: the machine's.
        band: distance of the tip from its goal within which it has to stay, of any length.

    Raises:
        InputError: angles or payload are wrong.
        UnreachedError: no openings were found that bring the tip to its goal.
    """
    if payload is not None:
        machine = changed(machine, "arm.payload", u.quantity(payload, u.MASS, "payload"))
    from_, to = (_joint_angles(machine, given) for given in (start, end))
    shooting, within = Shooting(machine, from_, to), u.quantity(band, u.LENGTH, "band")
    best = _first_trial(shooting, within)
    for seed in RESTART_SEEDS:
        best = _restart(best, seed)
    return _build_optimum(_extend_hold(best))


def _joint_angles(machine: Machine, angles: Angles) -> tuple[float, ...]:
    """Return the angles of all joints, rad."""
    start = start_angles(Scenario(start=angles), machine, np.zeros((1, len(machine.joints))))
    return tuple(start.tolist())


def _first_trial(shooting: Shooting, band: float) -> OpeningTrial:
    """Return a trial that settles: the tracking law's, improved, or one from switching openings.

    Raises:
        UnreachedError: no such trial is found.
    """
    law = simulate_tracking_law(shooting, band)
    best = None if law is None else reach_band(simulate_trial(shooting, law.openings, law.cycles, band), law.cycles)
    cycles = FIRST_CYCLES
    while best is None and cycles <= MAX_CYCLES:
        best = _reach_from_switching(shooting, cycles, band, RESTART_SEEDS[0])
        cycles *= 2
    if best is None:
        name = shooting.machine.name
        raise UnreachedError(
            f"no openings were found that bring the tip of {name} within {1e3 * band:g} mm of its goal"
        )
    return minimize_cycles(best)


def _reach_from_switching(shooting: Shooting, cycles: int, band: float, seed: int) -> OpeningTrial | None:
    """Return a trial that settles after so many cycles, from switching openings; None if the search fails."""
    return reach_band(
        simulate_trial(shooting, best_switching_openings(shooting, cycles, band, seed), cycles, band), cycles
    )


def _restart(best: OpeningTrial, seed: int) -> OpeningTrial:
    """Return the best trial, or a better one that begins with another sample of switching openings."""
    candidate = _reach_from_switching(best.shooting, best.settled - 1, best.band, seed) if best.settled > 1 else None
    return best if candidate is None else minimize_cycles(candidate)


def _extend_hold(best: OpeningTrial) -> OpeningTrial:
    """Return the best trial that stays for `HOLD_TIME`; one that leaves its band later is optimized over it.

    Raises:
        UnreachedError: no such trial is found.
    """
    tail = round(HOLD_TIME / best.shooting.machine.cycle)
    for cycles in range(best.settled, best.settled + TAIL_CYCLES):
        candidate = reach_band(simulate_trial(best.shooting, best.openings, cycles, best.band, tail), cycles)
        if candidate is not None:
            return candidate
    held = f"within {1e3 * best.band:g} mm of its goal for {HOLD_TIME:g} s"
    raise UnreachedError(f"no openings were found that keep the tip of {best.shooting.machine.name} {held}")


def _build_optimum(best: OpeningTrial) -> Optimum:
    """Return the result of the search with its rollout."""
    machine, start, end = best.shooting.machine, best.shooting.start, best.shooting.end
    rest = REST_CYCLES * machine.cycle
    openings = np.pad(best.openings, ((REST_CYCLES, 0), (0, 0)))
    duration = len(openings) * machine.cycle
    run = rollout(machine, duration=duration, start=list(start), opening=openings, noise=False)
    # A run in open loop has no demand; the goal takes its place, for the metrics.
    run["demand"] = run["demand"].copy(data=np.where(run["time"].to_numpy()[:, None] < rest - 1e-9, start, end))
    return Optimum(tip_settling(run, rest, inf, best.band), best.openings[: best.free], run, rest)
