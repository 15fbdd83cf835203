"""Joints that are thrown to their stops, where a log ends for a fit.

Where a joint goes from its stop hangs on the last digits of how it came, and what a stop does is not fitted: a search
that has to explain a hard impact may end anywhere.
"""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import CheckedLog, Issue, without_spikes
from layflat.machine import Machine

HARD, BEFORE = 5.0, 4  # rad/s over so many samples: joints under control come to their stops slower, if at all
RIGHT = "log it again, slower or over a smaller reach"


def impact(machine: Machine, joint: str, angles: Array, period: float) -> int | None:
    """First sample at which a joint comes to its stop at speed, or beyond its stroke to where its sensor ends.

    Args:
        machine: that it is a joint of.
        joint: its name.
        angles: as measured, rad, (samples,); not numbers in gaps.
        period: from sample to sample, s.
    """
    known = np.isfinite(angles)
    if not known.any():
        return None
    samples, stops, sensor = np.arange(len(angles)), machine.joints[joint].stops, machine.angle_sensor
    end = 0.5 * stops.mechanical_stroke
    if sensor is not None:
        seen = 0.5 * sensor.range - sensor.range / 2**sensor.bits
        end = min(end, max(seen, 0.5 * stops.working_stroke))
    whole = without_spikes(np.interp(samples, samples[known], angles[known]))
    outwards = np.sign(whole[BEFORE:]) * (whole[BEFORE:] - whole[:-BEFORE])
    found = np.flatnonzero((np.abs(whole[BEFORE:]) > end) & (outwards > HARD * BEFORE * period))
    return int(found[0]) + BEFORE if found.size else None


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Impacts, of a machine's joints."""
    if log.machine is None:
        return
    for joint in log.machine.joints:
        angle = log.of("angle", joint)
        if angle is None:
            continue
        first = impact(log.machine, joint, angle.values, log.period)
        if first is not None:
            text = f"is thrown to its stop at {log.time[first]:.3g} s"
            yield Issue("warning", angle.name, text, f"a fit goes no further: {RIGHT}")
