"""Sample the machines that the paper's findings allow: `python -m research.cloud --seed 1 --rounds 420 --out FILE`.

Machines begin near the results of calibrations from random points, and move over all unknowns within the limits of the
paper's findings. Those with which every claim agrees become members. Each start has a walk of its own, and the same
number of members as the others: in a common walk all would end near the start with the least shortfall. It takes an
hour and a half on two cores, and is reproducible if the time of the calibrations suffices.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from layflat.arrays import Array
from layflat.experiments.bench import load_bench
from layflat.experiments.reproduction import first_disagreement
from layflat.experiments.spread import cloud_file_members, map_in_processes
from layflat.machine.cloud import PAPER_CLOUD
from research.calibration.effort import FINAL_EFFORT, ROUGH_CLAIM_EFFORT, SINGLE_EFFORT, EvaluationEffort
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.calibration.stages import calibrate_machines
from research.cloud.made import write
from research.cloud.open import ARM, BLOCKS, excluded_values, place, values
from research.cloud.pinned import effective
from research.cloud.walk import Walk, start_walk

INITIAL_DEVIATION = 0.01  # of the machines' shares at the beginning of a walk
MAX_SHORTFALL = 0.55  # of machines in the end, the findings' margins included
MAX_MEMBERS = 252  # of a cloud, the same number from each start

WALK_STAGES = ((ROUGH_CLAIM_EFFORT, 256, 0.7), (SINGLE_EFFORT, 128, 0.5), (FINAL_EFFORT, 128, MAX_SHORTFALL))
"""Stages of a walk: effort, number of machines, and final level."""

Efforts = Sequence[tuple[EvaluationEffort, int, float]]

LOSS_KIND, CALIBRATION_MINUTES = "elasto-slip", 26.0  # of losses, and for each calibration


def starts(seed: int, count: int) -> Array:
    """Return the shares of machines from so many calibrations that begin at random points, (machines, unknowns).

    Raises:
        SystemExit: no machine agrees with all claims.
    """
    found = []
    for number in range(count):
        on, _, stages = calibrate_machines(LOSS_KIND, seed + number, CALIBRATION_MINUTES, anew=True)
        if all(best.agrees for best in stages):
            found.append(place({"paper-arm": on.arm, "paper-small-joint": on.axis_one, "earlier-actuator": on.earlier}))
    if not found:
        raise SystemExit(f"no calibration of {count} found a machine with which all claims agree: take other seeds")
    return np.stack(found)


def walk_from(
    findings: Findings,
    near: Array,
    *,
    seed: int,
    rounds: int,
    spread: float = INITIAL_DEVIATION,
    efforts: Efforts = WALK_STAGES,
) -> Iterator[tuple[Walk, bool]]:
    """Walk for a number of rounds from machines near given shares (machines, unknowns), with a standard deviation.

    Yields the walk, and whether it is at the last level.
    """
    rng, ladder = np.random.default_rng(seed), iter(efforts)
    effort, machines, least = next(ladder)

    def lacks(shares: Array, part: int, noise: int, level: Array) -> Array:
        return findings.lack(
            shares, lambda some: values(some, part), arm=part == ARM, seed=noise, effort=effort, level=level
        )

    first = near[rng.integers(len(near), size=machines)]
    shares = np.clip(first + spread * rng.standard_normal(first.shape), 0.0, 1.0)
    walk = start_walk(shares, 2, lacks, seed)
    while walk.rounds < rounds:
        walk.goes_on(BLOCKS, lacks, least)
        sys.stderr.write(
            f"{walk.rounds} of {rounds} rounds: level {walk.level:.2f}, "
            f"{walk.taken:.1%} of steps taken, {walk.shares.std(axis=0).mean():.3f} of the ranges covered\n"
        )
        last = effort is efforts[-1][0]
        yield walk, last and walk.level <= least
        if walk.level <= least and not last:
            effort, machines, least = next(ladder)
            walk.keep(machines)
            walk.look_again(lacks)


def agrees_with_all(where: str) -> bool:
    """Return whether every claim agrees with a member."""
    return not first_disagreement(load_bench(where))


def check_members(file: Path, walks: Sequence[Array], command: str, most: int) -> tuple[list[Array], int]:
    """Return machines with which every claim agrees, at most so many, and the number of machines evaluated.

    Asked is where machines were on their walk, in any order, until there are enough; all of them are written into a
    file on the way.
    """
    places = list({shares.tobytes(): shares for walk in walks for shares in walk}.values())
    np.random.default_rng(len(places)).shuffle(places)
    write(file, places, command)
    found, asked = list[Array](), 0
    results = map_in_processes(agrees_with_all, cloud_file_members(file, len(places)))
    for shares, agreeing in zip(places, results, strict=True):
        found, asked = [*found, shares] if agreeing else found, asked + 1
        sys.stderr.write(f"\r{len(found)} of {asked} machines agree with every claim, {len(places)} in all ")
        if len(found) == most:
            break
    sys.stderr.write("\n")
    return found, asked


def main() -> None:
    """Sample machines, check them by all claims, and write the cloud."""
    asked = argparse.ArgumentParser(prog="python -m research.cloud", description=__doc__)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--rounds", type=int, default=420, help="of steps")
    asked.add_argument("--starts", type=int, default=3, help="calibrations from anywhere, one seed after the other")
    asked.add_argument("--out", type=Path, default=PAPER_CLOUD)
    given = asked.parse_args()
    command = f"python -m research.cloud --seed {given.seed} --rounds {given.rounds} --starts {given.starts}"
    sys.stderr.writelines(f"{line}\n" for line in excluded_values())
    found, tried, worth = list[list[Array]](), 0, 0.0
    begins = starts(given.seed, given.starts)
    for number, start in enumerate(begins):
        walking = walk_from(
            Findings(Evidence(load_bench())), start[None], seed=given.seed + number, rounds=given.rounds
        )
        walks = [walk.shares.copy() for walk, last in walking if last]
        # Those of the first half may still remember where they began.
        later = walks[len(walks) // 2 :]
        if not later:
            sys.stderr.write(
                f"{given.rounds} rounds are too few for a start: no machine lacks {MAX_SHORTFALL:g} or less\n"
            )
            continue
        with TemporaryDirectory() as folder:
            agreeing, count = check_members(Path(folder) / given.out.name, later, command, MAX_MEMBERS // len(begins))
        found, tried, worth = [*found, agreeing], tried + count, worth + effective(later)
    members = [machine for each in zip(*filter(None, found), strict=False) for machine in each]
    if not members:
        raise SystemExit("no machine of any walk agrees with every claim")
    write(given.out, members, command, starts=sum(map(bool, found)), asked=tried, effective=round(worth, 1))


if __name__ == "__main__":
    main()
