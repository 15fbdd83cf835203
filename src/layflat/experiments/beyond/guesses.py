"""Openings with which the search for an optimum can begin."""

from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from layflat.arrays import Array
from layflat.experiments.beyond.search import LATE, TAIL, excess
from layflat.experiments.beyond.shooting import Shooting, settled
from layflat.machine.exchanged import with_tracking
from layflat.sim import rollout

SAMPLES = 1024  # of switching openings, of which the best counts; a power of two
GENTLEST = 0.3  # opening
BEFORE, AFTER = 0.5, 2.0  # of the tracking law's run, at rest and from the step on, s
STAYS = 40  # cycles that the law has to stay at the goal


class Followed(NamedTuple):
    """What the tracking law does: openings (cycles, joints), and after how many cycles the tip stays in its band."""

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
