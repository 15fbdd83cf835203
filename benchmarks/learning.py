"""Gain by repeating a move: error along the path after five repeats over that of the first run.

    python -m benchmarks.learning [PLANTS]

prints the figures of docs/learning.md. Plants differ from what the controller believes as in `tune.robust`;
noise is other noise in every repeat, and what is learnt is learnt from the sensors.
"""

import sys

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, load
from layflat.motion.curve import ArcCurve, LineCurve
from layflat.motion.kinematics import tip_position
from layflat.motion.learning import begin_learning
from layflat.motion.limits import FEEDBACK_RESERVE
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine, JointSpline
from layflat.motion.planar import PlanarPath
from layflat.motion.trajectory import Trajectory
from layflat.sim.repeats import learnt_error_ratio, simulated_repeats, true_error
from layflat.tune.robust import robust_plants

START = np.radians([-20.0, 0.0])
VIA = [[-30.0, 0.0], [0.0, 30.0], [20.0, 0.0], [30.0, -20.0]]


def motions(arm: Machine, reserve: float = FEEDBACK_RESERVE) -> dict[str, Trajectory]:
    """Time-optimal motions."""
    x, y = tip_position(arm, START).tolist()
    line = LineCurve.from_points((x, y), (x + 0.05, y + 0.25), "line")
    arc = ArcCurve.from_points((x, y), (x + 0.08, y + 0.1), (x, y + 0.22), "arc")
    paths = {
        "line": PlanarPath(arm, line, START, "line").check_reachable(),
        "arc": PlanarPath(arm, arc, START, "arc").check_reachable(),
        "via": JointSpline(arm, [np.radians(at) for at in VIA]),
        "joints": JointLine(np.radians([-20.0, -20.0]), np.radians([20.0, 20.0])),
    }
    return {name: plan_time_optimal(arm, path, reserve=reserve) for name, path in paths.items()}


def results(arm: Machine, moved: list[Machine], motion: Trajectory) -> Array:
    """Ratio, true errors (m) of the first run and of the best, landings (s) of both, of each plant: (plants, 5)."""
    rows = []
    for number, plant in enumerate(moved):
        learnt = begin_learning(arm, motion.rows(arm.cycle))
        done = list(simulated_repeats(learnt, 6, plant=plant, seed=1000 * number))
        history = done[-1].learnt.history
        best = max(k for k, repeat in enumerate(history) if repeat.kept)
        errors = [true_error(learnt, one.angles) for one in done]
        ratio = learnt_error_ratio(arm, plant, motion, seeds=[number])
        rows.append([ratio, errors[0], errors[best], history[0].arrival, history[best].arrival])
    return np.array(rows)


if __name__ == "__main__":
    arm, count = load("paper-arm-tracking"), int(sys.argv[1]) if len(sys.argv) > 1 else 48
    others_, same = robust_plants(arm, count), [arm] * 12
    print("ratio: median, three quarters, 90 %, worst; first and last rms error (mm), landing (s): medians")
    for reserve in (FEEDBACK_RESERVE, 0.5):
        together = []
        for name, motion in motions(arm, reserve).items():
            for what, moved in (("others", others_), ("as described", same)):
                found = results(arm, moved, motion)
                together += [found[:, 0]] if what == "others" else []
                ratios = " ".join(f"{np.quantile(found[:, 0], q):.2f}" for q in (0.5, 0.75, 0.9, 1.0))
                middle = np.median(found[:, 1:], axis=0)
                later = np.mean(found[:, 4] > found[:, 3] + arm.cycle * 1.5)
                print(
                    f"{reserve:4} {name:7} {motion.duration:.2f} s {what:13} {ratios}; {1e3 * middle[0]:.1f} "
                    f"{1e3 * middle[1]:.2f}; {middle[2]:+.3f} {middle[3]:+.3f}, later in {later:.0%}",
                    flush=True,
                )
        every = np.concatenate(together)
        told = " ".join(f"{np.quantile(every, q):.2f}" for q in (0.5, 0.75, 0.9, 1.0))
        print(f"{reserve:4} all motions, others: {told}, a quarter or less in {np.mean(every <= 0.25):.0%}")
