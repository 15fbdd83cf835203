"""How well the tracking controller performs planned motions, by the reserve that they leave to it.

    python -m benchmarks.motions [NAME]

prints the figures of docs/motion.md: medians over moves of 40 degrees of one or both joints in sixteen postures, each
with two noises; the motion is sent with its velocities and accelerations.
"""

import sys

import numpy as np

from layflat.arrays import Array
from layflat.experiments.beyond.moves import first_moves
from layflat.machine import Machine, load
from layflat.machine.exchanged import with_tracking
from layflat.motion.jerk_limited import plan_jerk_limited
from layflat.motion.kinematics import tip_position
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine
from layflat.motion.trajectory import MotionSequence, RestMotion, Trajectory
from layflat.sim import rollout

RESERVES = (0.0, 0.2, 0.35, 0.5)
BEFORE, AFTER = 0.3, 1.0  # rest before the motion and after it, s
NOISES, CLOSE = 2, 2e-3


def performed(machine: Machine, motion: Trajectory, start: Array, end: Array, seed: int) -> tuple[float, float]:
    """Return the rms distance of the tip from its demand while it moves (m), and when it is at the end for good (s)."""
    cycle = machine.cycle
    whole = MotionSequence.join(RestMotion(BEFORE, start), motion, RestMotion(AFTER, end)).rows(cycle)
    run = rollout(
        machine,
        whole.angles,
        demand_velocity=whole.velocities,
        demand_acceleration=whole.accelerations,
        duration=len(whole.angles) * cycle,
        seed=seed,
    )
    tips = tip_position(machine, run["angle"].to_numpy()[: len(whole.angles)])
    time = cycle * np.arange(len(tips)) - BEFORE
    moves = (time > 0.0) & (time < motion.duration)
    behind = np.linalg.norm(tips - tip_position(machine, whole.angles), axis=1)[moves]
    away = np.linalg.norm(tips - tip_position(machine, end), axis=1) > CLOSE
    return float(np.sqrt(np.mean(behind**2))), float(time[away][-1] + cycle)


def main() -> None:
    """Print a row for each reserve."""
    machine = with_tracking(load(sys.argv[1] if len(sys.argv) > 1 else "paper-arm-fast"))
    if machine is None:
        raise SystemExit("no tracking controller can drive this machine")
    for reserve in RESERVES:
        found, durations, gentle = [], [], []
        for start, end in first_moves(machine):
            path = JointLine(start, end)
            motion = plan_time_optimal(machine, path, reserve=reserve)
            durations.append(motion.duration)
            gentle.append(plan_jerk_limited(machine, path, reserve=reserve).duration)
            found += [performed(machine, motion, start, end, seed) for seed in range(NOISES)]
        rms, settled = np.array(found).T
        print(
            f"reserve {reserve}: duration {np.median(durations):.2f} s, with limited jerk {np.median(gentle):.2f} s; "
            f"rms {1e3 * np.median(rms):.1f} mm, 95 % {1e3 * np.quantile(rms, 0.95):.1f} mm; "
            f"within 2 mm after {np.median(settled):.2f} s, 95 % {np.quantile(settled, 0.95):.2f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
