"""Accuracy with which the tracking controller brings an arm's tip to places that it reaches, and along straight lines.

    python -m benchmarks.picking [NAME] [COUNT]

prints the figures of docs/control.md for `picking-arm`, or another machine in space: moves between places that are even
in the volume of its reach, and straight lines of the tip with 0.2 m/s, with payloads from nothing to 1 kg that the
controller does not know; on the arm as described, and on plants that differ from it (see `tune.robust`).
"""

import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.motion.curve import LineCurve
from layflat.motion.inverse import MIN_MOBILITY, InverseKinematics
from layflat.motion.kinematics import tip_position
from layflat.motion.limits import TipLimits
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.tip_path import SpacePath
from layflat.motion.trajectory import MotionSequence, RestMotion, States
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble
from layflat.tune.robust import PlantGroup, robust_plant_groups

HEAVIEST = 1.0  # payload, kg
CLOSE = 5e-3  # to a place, m
REST, PAUSE = 0.5, 1.5  # before a move, and for it, s
MOVES = 4  # after each other, where the payload is another one in each
SPEED, ACCELERATION = 0.2, 2.0  # of the tip on a line, m/s and m/s2
LENGTHS = 0.15, 0.35  # of lines, m


def late(values: Array) -> float:
    """Return what 95 of 100 values keep."""
    return float(np.quantile(values, 0.95, method="higher"))


def places(machine: Machine, count: int, seed: int = 1) -> Array:
    """Return postures (count, joints), rad, with tips even in the volume of the reach, each near the one before."""
    inverse, draw = InverseKinematics(machine), np.random.default_rng(seed)
    low, high = inverse.tips.min(axis=0), inverse.tips.max(axis=0)
    found: list[Array] = []
    near = np.zeros(len(machine.joints))
    while len(found) < count:
        posture = inverse.solve_globally(draw.uniform(low, high)[None], near)
        if posture.reached[0] and inverse.mobility(posture.angles)[0] > MIN_MOBILITY:
            near = posture.angles[0]
            found.append(near)
    return np.array(found)


def moves(postures: Array, count: int) -> list[Scenario]:
    """Return moves from each posture on, so many after each other."""
    times = [0.0, *(REST + PAUSE * k for k in range(count))]
    rows = [postures[k : k + count + 1].tolist() for k in range(len(postures) - count)]
    return [Scenario(demand=list(zip(times, row, strict=True)), duration=REST + PAUSE * count) for row in rows]


def lines(machine: Machine, count: int, seed: int = 2) -> list[States]:
    """Return motions along straight lines of the tip, from and to rest, a row a control cycle, all equally long."""
    draw, inverse, found = np.random.default_rng(seed), InverseKinematics(machine), list[States]()
    lasts = REST + LENGTHS[1] / SPEED + SPEED / ACCELERATION + 0.3
    cycles = round(lasts / machine.cycle)
    while len(found) < count:
        start = places(machine, 1, int(draw.integers(1 << 31)))[0]
        way, length = draw.normal(size=3), draw.uniform(*LENGTHS)
        tip = tip_position(machine, start)
        end = tip + length * way / np.linalg.norm(way)
        if not inverse.solve_globally(end[None], start).reached[0]:
            continue
        try:
            path = SpacePath(
                machine, LineCurve.from_points(tuple(tip), tuple(end), "line"), start, "line"
            ).check_reachable()
        except InputError:  # the arm does not get along it
            continue
        motion = plan_time_optimal(machine, path, tip=TipLimits(SPEED, ACCELERATION))
        rows = MotionSequence.join(RestMotion(REST, start), motion).rows(machine.cycle)
        if len(rows.angles) < cycles:
            pads = (0, cycles - len(rows.angles)), (0, 0)
            found.append(States(np.pad(rows.angles, pads, mode="edge"), *(np.pad(of, pads) for of in rows[1:])))
    return found


def settled(
    machine: Machine, scenarios: Sequence[Scenario], seed: int, *, differing: bool = False, heaviest: float = HEAVIEST
) -> Array:
    """Return settling times of the tip (runs, moves), s, with a payload a run that the controller does not know."""
    found = []
    for plant, rows, vary in _plants(machine, len(scenarios), seed, differing, heaviest):
        chosen = [scenarios[k] for k in rows]
        runs = ensemble(plant, chosen, vary, controller=machine, tip_band=CLOSE)
        found.append(runs["tip_settling"].to_numpy())
    return _or_never(np.concatenate(found))


def followed(
    machine: Machine, motions: Sequence[States], seed: int, *, differing: bool = False, heaviest: float = HEAVIEST
) -> Array:
    """Return rms distances of the tip from where it should be while it moves (runs,), m; infinite if a run diverged."""
    found: list[float] = []
    for plant, rows, vary in _plants(machine, len(motions), seed, differing, heaviest):
        chosen = [motions[k] for k in rows]
        lasts = machine.cycle * len(chosen[0].angles)
        scenarios = [Scenario(demand=q, demand_velocity=v, demand_acceleration=a, duration=lasts) for q, v, a in chosen]
        traced = ensemble(plant, scenarios, vary, controller=machine, traces=("angle",))["angle"].to_numpy()
        for asked, angles in zip(chosen, traced, strict=True):
            away = np.linalg.norm(tip_position(machine, angles) - tip_position(machine, asked.angles), axis=1)
            going = np.any(asked.velocities != 0.0, axis=1)
            found.append(float(np.sqrt(np.mean(away[going] ** 2))))
    return _or_never(np.array(found))


def _or_never(values: Array) -> Array:
    """Return values, infinite where a run diverged."""
    return np.nan_to_num(values, nan=np.inf, posinf=np.inf)


def _plants(
    machine: Machine, count: int, seed: int, differing: bool, heaviest: float
) -> list[tuple[Machine, list[int], dict[str, ArrayLike]]]:
    """Return plants, numbers of the scenarios that they run, and what varies."""
    draw, first = np.random.default_rng(seed), 0
    found: list[tuple[Machine, list[int], dict[str, ArrayLike]]] = []
    sets = robust_plant_groups(machine, count, seed=seed) if differing else [PlantGroup(machine, {})]
    for plant, own in [(of.machine, of.vary) for of in sets]:
        size = len(own["valve.delay"]) if own else count
        rows = np.arange(first, first + size)
        vary: dict[str, ArrayLike] = dict(own)
        vary |= {"scenario": rows - first, "seed": rows, "scenario.payload": draw.uniform(0.0, heaviest, size)}
        found.append((plant, rows.tolist(), vary))
        first += size
    return found


def changing(machine: Machine, postures: Array, seed: int) -> Array:
    """Return settling times (runs x moves,), s, of moves with a new payload each, which is there when a move begins."""
    draw = np.random.default_rng(seed)
    scenarios = []
    for one in moves(postures, MOVES)[::MOVES]:
        loads = draw.uniform(0.0, HEAVIEST, MOVES + 1).tolist()
        times = [0.0, *(REST + PAUSE * k for k in range(MOVES))]
        steps = [(time, load) for time, load in zip(times, loads, strict=True)]
        scenarios.append(Scenario(demand=one.demand, duration=one.duration, payload=steps))
    count = np.arange(len(scenarios))
    runs = ensemble(machine, scenarios, {"scenario": count, "seed": count}, tip_band=CLOSE)
    return _or_never(runs["tip_settling"].to_numpy().ravel())


def main() -> None:
    """Print a row for each kind of trial."""
    machine = load(sys.argv[1] if len(sys.argv) > 1 else "picking-arm")
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    postures, along = places(machine, count + 1), lines(machine, count)
    single = moves(postures, 1)
    for what, times in (
        ("as described, payload unknown", settled(machine, single, 3).ravel()),
        ("nothing carried, which is not known", settled(machine, single, 3, heaviest=0.0).ravel()),
        ("payload another one in each move", changing(machine, postures, 4)),
        ("plants that differ, payload unknown", settled(machine, single, 5, differing=True).ravel()),
    ):
        print(
            f"{what}: within {1e3 * CLOSE:g} mm after {np.median(times):.2f} s, 95 % {late(times):.2f} s; "
            f"{np.mean(times <= 1.0):.1%} of {len(times)} in 1 s, {int(np.sum(np.isinf(times)))} not at all",
            flush=True,
        )
    for what, away in (
        ("lines as described", followed(machine, along, 6)),
        ("lines, nothing carried", followed(machine, along, 6, heaviest=0.0)),
        ("lines, plants that differ", followed(machine, along, 6, differing=True)),
    ):
        print(
            f"{what}: {1e3 * np.median(away):.2f} mm rms, 95 % {1e3 * late(away):.2f} mm, "
            f"most {1e3 * away.max():.2f} mm; {np.mean(away <= CLOSE):.1%} of {len(away)} within 5 mm",
            flush=True,
        )


if __name__ == "__main__":
    main()
