"""Least time of a step: openings of the valves, found offline by whoever knows all of the plant.

It is a bound for any controller, as near as a search can come: no controller of the same valves gets to know more. Its
openings are found on the simulated plant itself, so valves, air, friction and hysteresis are all in it. The search
begins with what the tracking law does, and with the best of many openings that speed up, brake, and let go.
"""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from layflat.arrays import Array, Dataset
from layflat.description import units as u
from layflat.errors import UnreachedError
from layflat.experiments.beyond.search import LATE, TAIL, Trial, excess, least_cycles, reach, trial
from layflat.experiments.beyond.shooting import REST, Shooting, settled
from layflat.machine import Machine, changed
from layflat.machine.exchanged import with_tracking
from layflat.motion.scenario import Scenario
from layflat.motion.signal_values import Angles, Value
from layflat.sim import rollout
from layflat.sim.ensemble.parallel import TIP_BAND
from layflat.sim.metrics import tip_settling
from layflat.sim.run import start_angles

SAMPLES = 1024  # of switching openings, of which the best counts; a power of two
GENTLEST = 0.3  # opening
BEFORE, AFTER = 0.5, 2.0  # of the tracking law's run, at rest and from the step on, s
STAYS = 40  # cycles that the law has to stay at the goal


class Followed(NamedTuple):
    """Run of the tracking law: openings (cycles, joints), and after how many cycles the tip stays in its band."""

    openings: Array
    cycles: int


def tracked(shooting: Shooting, band: float) -> Followed | None:
    """Return what the tracking law does without noise; None where it can't model the machine or does not settle.

    Args:
        shooting: the step.
        band: m.
    """
    machine = with_tracking(shooting.machine)
    if machine is None or machine.valve is None:
        return None
    demand = [(0.0, list(shooting.start)), (BEFORE, list(shooting.end))]
    run = rollout(machine, demand, duration=BEFORE + AFTER, noise=False)
    begins = round(BEFORE / machine.cycle)
    cycles = int(settled(run["tip"].to_numpy()[begins + 1 :] - shooting.goal, band))
    voltage = run["voltage"].to_numpy()[begins:-1]
    openings = np.clip((voltage - machine.valve.centre_voltage) / machine.valve.volts_to_full, -1.0, 1.0)
    return Followed(openings, cycles) if cycles < len(openings) - STAYS else None


def switching(shooting: Shooting, cycles: int, band: float, seed: int) -> Array:
    """Return the best of many openings that speed up, brake, and let go, (cycles and a tail, joints).

    Args:
        shooting: the step.
        cycles: after which the tip is to stay in its band.
        band: m.
        seed: of the sample.
    """
    joints = len(shooting.start)
    ways = np.sign(np.round(np.subtract(shooting.end, shooting.start), 6))
    draws = qmc.Sobol(7 * joints, seed=seed).random(SAMPLES).reshape(SAMPLES, 7, joints)
    # A joint that is to stay has to be held against the other's motion, either way.
    sides = np.where(ways == 0.0, np.sign(draws[:, 0] - 0.5), ways)
    until = np.sort(draws[:, 1:4], axis=1) * (cycles + LATE)
    sizes = GENTLEST + (1.0 - GENTLEST) * draws[:, 4:]
    openings = np.zeros((SAMPLES, cycles + TAIL, joints))
    since, k = np.zeros((SAMPLES, joints)), np.arange(cycles + TAIL)[None, :, None]
    for i, sign in enumerate((1.0, -1.0, 1.0)):
        # A switch within a cycle holds for its share of it.
        share = np.clip(until[:, None, i] - k, 0.0, 1.0) - np.clip(since[:, None] - k, 0.0, 1.0)
        openings += sign * (sides * sizes[:, i])[:, None] * share
        since = until[:, i]
    best: Array = openings[np.argmin(excess(shooting.errors(openings), cycles, band))]
    return best


SEEDS = (0, 1)  # of further beginnings of the search
WATCHED = 1.0  # how long the tip has to stay within its band, s
FIRST, LONGEST = 20, 640  # cycles in which a step is tried where no law gives a time


@dataclass(frozen=True)
class Optimum:
    """The fastest step that was found.

    Args:
        settling: time from the step until the tip stays within its band for good, s.
        openings: of the valves from the step on, -1..1, (cycles, joints).
        run: the step, from `rest` on and until the tip has stayed for a second.
        rest: time in `run` at which the step begins, s.
    """

    settling: float
    openings: Array
    run: Dataset
    rest: float


def settling_bound(
    machine: Machine, start: Angles, end: Angles, *, payload: Value | None = None, band: Value = TIP_BAND
) -> Optimum:
    """Find the least time after which a machine's tip can be at its goal for good, with all known and without noise.

    The arm is at rest at first; valves are driven open-loop, by an opening for each control cycle. The search begins
    with what the tracking controller does, where the machine can have one, and with openings that switch; the best
    counts. It is deterministic. Times are whole control cycles. The openings found do what is claimed, and faster ones
    may exist: searches that begin elsewhere end one or two cycles apart, seldom more.

    The hoses begin with what equal leakage leaves in them, which bears no gravity: the arm has to be level.

    Args:
        machine: whose plant it is; its controller gives the cycle and does nothing else.
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
    from_, to = (_angles(machine, given) for given in (start, end))
    shooting, within = Shooting(machine, from_, to), u.quantity(band, u.LENGTH, "band")
    best = _first(shooting, within)
    for seed in SEEDS:
        best = _restarted(best, seed)
    return _shown(_lasting(best))


def _angles(machine: Machine, given: Angles) -> tuple[float, ...]:
    """Angles of all joints, rad."""
    found = start_angles(Scenario(start=given), machine, np.zeros((1, len(machine.joints))))
    return tuple(found.tolist())


def _first(shooting: Shooting, band: float) -> Trial:
    """A trial that settles: the tracking law's, improved, or one of openings that switch."""
    law = tracked(shooting, band)
    found = None if law is None else reach(trial(shooting, law.openings, law.cycles, band), law.cycles)
    cycles = FIRST
    while found is None and cycles <= LONGEST:
        found = _begun(shooting, cycles, band, SEEDS[0])
        cycles *= 2
    if found is None:
        name = shooting.machine.name
        raise UnreachedError(
            f"no openings were found that bring the tip of {name} within {1e3 * band:g} mm of its goal"
        )
    return least_cycles(found)


def _begun(shooting: Shooting, cycles: int, band: float, seed: int) -> Trial | None:
    """A trial that settles after so many cycles, from openings that switch; None if none is found."""
    return reach(trial(shooting, switching(shooting, cycles, band, seed), cycles, band), cycles)


def _restarted(best: Trial, seed: int) -> Trial:
    """The best trial, or a better one that begins elsewhere."""
    found = _begun(best.shooting, best.settled - 1, best.band, seed) if best.settled > 1 else None
    return best if found is None else least_cycles(found)


def _lasting(best: Trial) -> Trial:
    """The best trial that stays for long; one that leaves its band late is sought anew with that in sight."""
    tail = round(WATCHED / best.shooting.machine.cycle)
    for cycles in range(best.settled, best.settled + TAIL):
        found = reach(trial(best.shooting, best.openings, cycles, best.band, tail), cycles)
        if found is not None:
            return found
    raise UnreachedError(f"no openings were found that keep the tip of {best.shooting.machine.name} at its goal")


def _shown(best: Trial) -> Optimum:
    """Return what was found, with its rollout."""
    machine, start, end = best.shooting.machine, best.shooting.start, best.shooting.end
    rest = REST * machine.cycle
    openings = np.pad(best.openings, ((REST, 0), (0, 0)))
    lasting = len(openings) * machine.cycle
    run = rollout(machine, duration=lasting, start=list(start), opening=openings, noise=False)
    # Nothing is asked of a run in open loop: its goal is laid beside it, to be measured by.
    run["demand"] = run["demand"].copy(data=np.where(run["time"].to_numpy()[:, None] < rest - 1e-9, start, end))
    return Optimum(tip_settling(run, rest, inf, best.band), best.openings[: best.free], run, rest)
