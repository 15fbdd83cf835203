"""Losses of hose and strap beside the brake: the same total hysteresis, another damping."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import GOOD_TIME, SCAN
from layflat.experiments.bench import INERTIA_PER_TORQUE
from layflat.experiments.questions.tables import JOINT, grid, hysteresis, inertia_per_torque, limits
from layflat.machine import changed
from layflat.plot.style import LINES
from layflat.plot.style import figure as new_figure
from layflat.study import Study

TOTALS = (15.0, 20.0, 25.0, 30.0)  # total hysteresis, %
LOSS, BRAKE, PAYLOAD = "joint.small.hose.loss_share", "joint.small.brake.torque", "scenario.payload"
"""Columns of the table."""
MUCH = 1.25  # what carries so many times as much carries more
CALM = 0.05  # less motion than this is rest, deg


def _lines(study: Study, frame: pandas.DataFrame) -> dict[float, Array]:
    """By total hysteresis: share of the brake in it, limits of inertia in 1.5 and in 4 s, ripple that is left (deg)."""
    machine = study.machine
    losses, brakes = (np.sort(frame[column].unique()) for column in (LOSS, BRAKE))
    lossless = changed(machine, LOSS, 0.0)
    of_loss = np.array([hysteresis(changed(machine, LOSS, loss), 0.0) for loss in losses])
    of_brake = [hysteresis(changed(lossless, BRAKE, torque)) for torque in brakes]
    found = {}
    for total in TOTALS:
        rows = []
        for torque, own in zip(brakes, of_brake, strict=True):
            nearest = int(np.argmin(np.abs(of_loss + own - total)))
            if abs(of_loss[nearest] + own - total) > 0.5 * (of_loss[1] - of_loss[0]):
                continue
            here = frame[(frame[LOSS] == losses[nearest]) & (frame[BRAKE] == torque)]
            _, payloads, times = grid(here, BRAKE, PAYLOAD, f"settling.{JOINT}.0")
            ripple = grid(here, BRAKE, PAYLOAD, f"ripple.{JOINT}.0")[2]
            ratios = inertia_per_torque(machine, payloads)
            compared = int(np.argmin(np.abs(np.log(ratios / INERTIA_PER_TORQUE))))
            limit = [float(limits(ratios, times, allowed)[0]) for allowed in (GOOD_TIME, SCAN)]
            rows.append((own / total, *limit, float(np.degrees(ripple[compared, 0]))))
        if rows:
            found[total] = np.array(rows).T
    return found


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw a line for each total."""
    with new_figure(1, 2, width=8.6, height=3.6) as (made, (limit, ripple)):
        for order, (total, (share, _, slow, left)) in enumerate(_lines(study, frame).items()):
            for axes, values in ((limit, slow), (ripple, left)):
                style = {**LINES[order], "marker": "os^D"[order], "ms": 4}
                axes.plot(100 * share, values, label=f"{total:g} % in all", **style)
        limit.set_ylabel("Inertia that settles (kg m$^2$ per N m)")
        ripple.set_ylabel("Left of the motion (deg, peak to peak)")
        for axes in (limit, ripple):
            axes.set(xlabel="Of this hysteresis from the brake (%)", ylim=(0.0, None))
        ripple.legend()
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Say how much more a brake gives at the paper's total, and what of it is needed."""
    lines = _lines(study, frame)
    total = min(lines, key=lambda one: abs(one - 25.0))
    share, quick, slow, left = lines[total]
    hose, brake = int(np.argmin(share)), int(np.argmax(slow))
    better = "Where the hysteresis comes from makes little difference"
    if slow[brake] > MUCH * slow[hose]:
        better = f"The same hysteresis damps {_times(slow[brake], slow[hose])} better in a brake"
    said = (
        f"At {total:g} % of total hysteresis a joint with {_mostly(share[hose])} carries {slow[hose]:.3f} kg m2 per "
        f"N m ({SCAN:g} s allowed), the best division {slow[brake]:.3f}, with {100 * share[brake]:.0f} % of it in the "
        f"brake. {better}. Within {GOOD_TIME:g} s it is {quick[hose]:.3f} and {quick[brake]:.3f}. At the paper's "
        f"inertia {_left(left[hose])} with {_mostly(share[hose])}, {_left(left[brake])} with the best division."
    )
    calm = share[left < CALM]
    if 0 < len(calm) < len(share):
        said += f" From {100 * calm.min():.0f} % of it in the brake on the joint comes to rest."
    return said


def _mostly(share: float) -> str:
    return "all of it in the hose" if share == 0.0 else f"{100 * share:.0f} % of it in the brake"


def _left(ripple: float) -> str:
    return "nothing is left of the motion" if ripple < CALM else f"{ripple:.1f} deg of motion are left"


def _times(more: float, less: float) -> str:
    return f"{more / less:.1f} times" if less > 0.0 else "incomparably"
