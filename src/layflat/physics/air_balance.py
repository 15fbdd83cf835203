"""Observer of the air in a joint's hoses: its residual shows a stuck spool, a kinked hose or a leak.

| symbol | meaning | unit |
|---|---|---|
| p_a, p_b | absolute pressures in hoses A and B, estimated | Pa |
| V | volume of a hose: dead volume, and K per travel | m3 |
| K | torque per pressure, which is volume per travel | m3/rad |
| s | travel of a hose: neutral travel and angle | rad |
| u | commanded opening of the valve, -1..1 | 1 |
| C | sonic conductance of a fully open path (ISO 6358-1) | m3/(s Pa) |
| C_l | the same of the tube to the hose | m3/(s Pa) |
| L | observer gain | 1/s |
| d | residual: air flow that the command does not explain, as an opening of the valve | 1 |

The air is taken as isothermal, V p' = p_0 C (...) - p K v, and the estimate is corrected towards the measured
differential pressure (a Luenberger observer). The correction is the residual: near zero while spool and hoses have
no fault, the negative of the commanded opening while a spool sticks in the middle or a hose is kinked, and the size of
the hole while a hose loses air.
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air import GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.flow import effective_pressure
from layflat.physics.ramp import mean_above_zero

REFERENCE_PRESSURE = REFERENCE_DENSITY * GAS_CONSTANT * REFERENCE_TEMPERATURE
"""p_0: pressure at which ISO 6358 counts volumes, Pa."""

PRESSURE_SUBSTEPS = 5  # in a control cycle: pressures may change by a bar in 10 ms
RESIDUAL_SMOOTHING_TIME = 0.05  # time over which the residual is averaged: a few periods of the dither, s
MAX_UPDATE_TIME = (
    0.02  # s: after a longer pause the estimate is followed for so long only, since larger steps would diverge
)


class AirObserverParameters(NamedTuple):
    """Parameters of the observer of one joint (units as in the module's table)."""

    dead_volume: float
    torque_constant: float
    neutral: float
    conductance: float
    leakage: float
    line_conductance: float  # of the tube to the hose; infinite where there is none
    critical_ratio: float
    laminar_slope: float
    overlap: float
    dither: float  # amplitude of the spool's dither, fraction of full opening
    follow: float  # L, 1/s
    smoothing: float  # time over which the residual is averaged, s
    fastest: float  # upper limit of the velocity, rad/s: an angle that jumps further is a fault of the sensor


class AirEstimate(NamedTuple):
    """Estimate of the air in a joint's hoses after a cycle."""

    pressure_a: float  # Pa
    pressure_b: float  # Pa
    angle: float  # measured at the end of the cycle, rad
    residual: float  # averaged
    taken: float = 0.0  # mass drawn from the supply so far, kg


@law
def _mean_path_conductance(parts, u):
    """Return the conductance of valve path and tube in series at an opening u of the path, averaged over the dither."""
    opening = mean_above_zero(u - parts.dither - parts.overlap, u + parts.dither - parts.overlap)
    opening = min(opening / (1.0 - parts.overlap), 1.0)
    through = parts.leakage + (parts.conductance - parts.leakage) * opening
    # Valve and tube in series (ISO 6358-3).
    narrowed = through / parts.line_conductance
    return through / sqrt(1.0 + narrowed * narrowed)


@law
def _signed_effective_pressure(parts, p, p_e):
    """Return the effective pressure of the flow from p to p_e, Pa, negative where it flows the other way."""
    drives = effective_pressure(max(p, p_e), min(p, p_e), parts.critical_ratio, parts.laminar_slope)
    return drives if p >= p_e else -drives


@law
def _inflow(come, go, fills, vents):
    return REFERENCE_PRESSURE * (fills * come - vents * go)


@law
def update_air_estimate(parts, estimate, opening, angle, difference, supply, exhaust, elapsed):
    """Return the estimate after a cycle of `elapsed` seconds in which `opening` was commanded.

    Args: `AirObserverParameters`, `AirEstimate`, opening (-1..1), present angle (rad) and differential pressure (Pa),
    absolute pressures of the supply and of the exhaust (Pa), s.
    """
    K, h = parts.torque_constant, min(elapsed, MAX_UPDATE_TIME) / PRESSURE_SUBSTEPS
    velocity = min(max((angle - estimate.angle) / elapsed, -parts.fastest), parts.fastest)
    volume_a = max(parts.dead_volume + K * (parts.neutral + angle), 0.5 * parts.dead_volume)
    volume_b = max(parts.dead_volume + K * (parts.neutral - angle), 0.5 * parts.dead_volume)
    fills, vents = _mean_path_conductance(parts, opening), _mean_path_conductance(parts, -opening)
    p_a, p_b, correction, taken = estimate.pressure_a, estimate.pressure_b, 0.0, estimate.taken
    for _ in range(PRESSURE_SUBSTEPS):
        injection = 0.5 * parts.follow * (difference - (p_a - p_b))
        correction += injection
        come_a, go_a = _signed_effective_pressure(parts, supply, p_a), _signed_effective_pressure(parts, p_a, exhaust)
        come_b, go_b = _signed_effective_pressure(parts, supply, p_b), _signed_effective_pressure(parts, p_b, exhaust)
        taken += h * REFERENCE_DENSITY * (fills * max(come_a, 0.0) + vents * max(come_b, 0.0))
        p_a += h * ((_inflow(come_a, go_a, fills, vents) - p_a * K * velocity) / volume_a + injection)
        p_b += h * ((_inflow(come_b, go_b, vents, fills) + p_b * K * velocity) / volume_b - injection)
        p_a, p_b = max(p_a, 0.5 * exhaust), max(p_b, 0.5 * exhaust)
    full = REFERENCE_PRESSURE * parts.conductance * supply * 0.5 * (1.0 / volume_a + 1.0 / volume_b)
    weight = elapsed / parts.smoothing
    residual = estimate.residual + min(weight, 1.0) * (
        correction / (PRESSURE_SUBSTEPS * 0.5 * full) - estimate.residual
    )
    return AirEstimate(p_a, p_b, angle, residual, taken)
