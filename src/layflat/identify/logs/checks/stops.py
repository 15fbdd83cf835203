"""Joints that hit their stops, where a fit stops using a log.

The motion after an impact depends on the last digits of the motion before it, and stops are not fitted: a search that
has to explain a hard impact may end anywhere.
"""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import CheckedLog, Issue, median_filter
from layflat.machine import Machine

IMPACT_SPEED = 5.0  # rad/s: joints under control come to their stops slower, if at all
IMPACT_SAMPLES = 4  # over which that speed is measured
IMPACT_ADVICE = "log it again, slower or over a smaller reach"


def find_impact(machine: Machine, joint: str, angles: Array, period: float) -> int | None:
    """Return the index of the first sample at which a joint hits a stop at speed, or None.

    An impact is a median-filtered angle beyond the mechanical stop, or beyond the sensor's range (but never inside the
    working stroke), reached outwards faster than `IMPACT_SPEED` (rad/s) over `IMPACT_SAMPLES` samples.

    Args:
        machine: machine with the joint.
        joint: name of the joint.
        angles: measured angles, rad, (samples,), NaN in gaps.
        period: time between samples, s.
    """
    finite = np.isfinite(angles)
    if not finite.any():
        return None
    samples, stops, sensor = np.arange(len(angles)), machine.joints[joint].stops, machine.angle_sensor
    end = 0.5 * stops.mechanical_stroke
    if sensor is not None:
        readable = 0.5 * sensor.range - sensor.range / 2**sensor.bits
        end = min(end, max(readable, 0.5 * stops.working_stroke))
    filtered = median_filter(np.interp(samples, samples[finite], angles[finite]))
    outwards = np.sign(filtered[IMPACT_SAMPLES:]) * (filtered[IMPACT_SAMPLES:] - filtered[:-IMPACT_SAMPLES])
    impacts = np.flatnonzero(
        (np.abs(filtered[IMPACT_SAMPLES:]) > end) & (outwards > IMPACT_SPEED * IMPACT_SAMPLES * period)
    )
    return int(impacts[0]) + IMPACT_SAMPLES if impacts.size else None


def stop_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield a warning for the first impact of each joint of a machine; nothing without a machine."""
    if log.machine is None:
        return
    for joint in log.machine.joints:
        angle = log.find_channel("angle", joint)
        if angle is None:
            continue
        first = find_impact(log.machine, joint, angle.values, log.period)
        if first is not None:
            text = f"is thrown to its stop at {log.time[first]:.3g} s"
            yield Issue("warning", angle.name, text, f"a fit goes no further: {IMPACT_ADVICE}")
