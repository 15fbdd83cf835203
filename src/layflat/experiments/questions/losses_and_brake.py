"""Division of the total hysteresis between losses of hose and strap and the brake: damping."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import LONG_SETTLING_LIMIT, SETTLING_GOAL
from layflat.experiments.bench import INERTIA_PER_TORQUE
from layflat.experiments.questions import (
    STUDIED_JOINT,
    inertia_limits,
    inertia_per_torque,
    median_grid,
    total_hysteresis,
)
from layflat.machine import changed
from layflat.plot.style import series_style
from layflat.plot.style import styled_figure as new_figure
from layflat.study import Study

TOTAL_LEVELS = (15.0, 20.0, 25.0, 30.0)  # total hysteresis, %
LOSS_COLUMN, BRAKE_COLUMN, PAYLOAD_COLUMN = (
    "joint.small.hose.loss_fraction",
    "joint.small.brake.torque",
    "scenario.payload",
)
"""Columns of the table."""
MARKED_RATIO = 1.25  # of inertias, from which on one is reported as better
REST_RIPPLE = 0.05  # upper limit of the ripple of a joint at rest, peak to peak, deg


def _division_curves(study: Study, frame: pandas.DataFrame) -> dict[float, Array]:
    """Return curves by total hysteresis (%): rows of fraction, limits and ripple over divisions.

    The rows: fraction of the brake in the hysteresis, limits of inertia per torque in 1.5 and in 4 s, ripple (deg).
    """
    machine = study.machine
    losses, brakes = (np.sort(frame[column].unique()) for column in (LOSS_COLUMN, BRAKE_COLUMN))
    lossless = changed(machine, LOSS_COLUMN, 0.0)
    of_loss = np.array([total_hysteresis(changed(machine, LOSS_COLUMN, loss), 0.0) for loss in losses])
    of_brake = [total_hysteresis(changed(lossless, BRAKE_COLUMN, torque)) for torque in brakes]
    curves = {}
    for total in TOTAL_LEVELS:
        rows = []
        for torque, brake_hysteresis in zip(brakes, of_brake, strict=True):
            nearest = int(np.argmin(np.abs(of_loss + brake_hysteresis - total)))
            if abs(of_loss[nearest] + brake_hysteresis - total) > 0.5 * (of_loss[1] - of_loss[0]):
                continue
            selected = frame[(frame[LOSS_COLUMN] == losses[nearest]) & (frame[BRAKE_COLUMN] == torque)]
            _, payloads, times = median_grid(selected, BRAKE_COLUMN, PAYLOAD_COLUMN, f"settling.{STUDIED_JOINT}.0")
            ripple = median_grid(selected, BRAKE_COLUMN, PAYLOAD_COLUMN, f"ripple.{STUDIED_JOINT}.0")[2]
            ratios = inertia_per_torque(machine, payloads)
            compared = int(np.argmin(np.abs(np.log(ratios / INERTIA_PER_TORQUE))))
            limit = [
                float(inertia_limits(ratios, times, limit_time)[0])
                for limit_time in (SETTLING_GOAL, LONG_SETTLING_LIMIT)
            ]
            rows.append((brake_hysteresis / total, *limit, float(np.degrees(ripple[compared, 0]))))
        if rows:
            curves[total] = np.array(rows).T
    return curves


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw inertia limit and residual motion over the fraction of the brake, a line for each total hysteresis."""
    with new_figure(1, 2, width=8.6, height=3.6) as (fig, (limit, ripple)):
        for order, (total, (share, _, slow, residual)) in enumerate(_division_curves(study, frame).items()):
            for axes, values in ((limit, slow), (ripple, residual)):
                style = {**series_style(order), "marker": "os^D"[order % 4], "ms": 4}
                axes.plot(100 * share, values, label=f"{total:g} % in all", **style)
        limit.set_ylabel("Inertia that settles (kg m$^2$ per N m)")
        ripple.set_ylabel("Left of the motion (deg, peak to peak)")
        for axes in (limit, ripple):
            axes.set(xlabel="Of this hysteresis from the brake (%)", ylim=(0.0, None))
        ripple.legend()
    return fig


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Return text on the best division at the paper's total hysteresis, and the fraction of it that the brake needs."""
    lines = _division_curves(study, frame)
    total = min(lines, key=lambda level: abs(level - 25.0))
    share, within_goal, within_long, residual = lines[total]
    hose, brake = int(np.argmin(share)), int(np.argmax(within_long))
    better = "Where the hysteresis comes from makes little difference"
    if within_long[brake] > MARKED_RATIO * within_long[hose]:
        better = f"The same hysteresis damps {_describe_ratio(within_long[brake], within_long[hose])} better in a brake"
    text = (
        f"At {total:g} % of total hysteresis a joint with {_describe_division(share[hose])} carries "
        f"{within_long[hose]:.3f} kg m2 per N m ({LONG_SETTLING_LIMIT:g} s allowed), the best division "
        f"{within_long[brake]:.3f}, with {100 * share[brake]:.0f} % of it in the brake. {better}. "
        f"Within {SETTLING_GOAL:g} s it is {within_goal[hose]:.3f} and {within_goal[brake]:.3f}. "
        f"At the paper's inertia {_describe_ripple(residual[hose])} with {_describe_division(share[hose])}, "
        f"{_describe_ripple(residual[brake])} with the best division."
    )
    at_rest = share[residual < REST_RIPPLE]
    if 0 < len(at_rest) < len(share):
        text += f" From {100 * at_rest.min():.0f} % of it in the brake on the joint comes to rest."
    return text


def _describe_division(share: float) -> str:
    return "all of it in the hose" if share == 0.0 else f"{100 * share:.0f} % of it in the brake"


def _describe_ripple(ripple: float) -> str:
    return "nothing is left of the motion" if ripple < REST_RIPPLE else f"{ripple:.1f} deg of motion are left"


def _describe_ratio(more: float, less: float) -> str:
    return f"{more / less:.1f} times" if less > 0.0 else "incomparably"
