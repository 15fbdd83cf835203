"""Does the air in a joint's hoses do what its valve was told? An estimate that needs the sensors alone.

| symbol | meaning | unit |
|---|---|---|
| p_a, p_b | absolute pressures in hoses A and B, estimated | Pa |
| V | volume of a hose: dead volume, and K per travel | m3 |
| K | torque per pressure, which is volume per travel | m3/rad |
| s | travel of a hose: neutral travel and angle | rad |
| u | opening asked of the valve, -1..1 | 1 |
| C | sonic conductance of a fully open path (ISO 6358-1) | m3/(s Pa) |
| C_l | the same of the tube to the hose | m3/(s Pa) |
| L | rate at which the estimate follows what is measured | 1/s |
| d | residual: what the air does beyond what was asked, as an opening of the valve | 1 |

The air is taken as isothermal, V p' = p_0 C (...) - p K v, and the estimate is corrected towards the measured
differential pressure (a Luenberger observer). How much it is corrected is the residual: near zero while spool and hoses
are sound, the opening that was asked for, turned round, while a spool sticks in the middle or a hose is kinked, and the
hole's size while a hose loses air.
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air import GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.flow import effective_pressure
from layflat.physics.ramp import mean_above_zero

REFERENCE_PRESSURE = REFERENCE_DENSITY * GAS_CONSTANT * REFERENCE_TEMPERATURE
"""p_0: pressure at which ISO 6358 counts volumes, Pa."""

SUBSTEPS = 5  # in a control cycle: pressures may change by a bar in 10 ms
SMOOTHING = 0.05  # time over which the residual is averaged: a few periods of the dither, s
LONGEST = 0.02  # s: after a longer pause the estimate is followed for so long only, since larger steps would diverge


class AirParts(NamedTuple):
    """What the watch knows of a joint (units as in the module's table)."""

    dead_volume: float
    torque_constant: float
    neutral: float
    conductance: float
    leakage: float
    line_conductance: float  # of the tube to the hose; infinite where there is none
    critical_ratio: float
    laminar_slope: float
    overlap: float
    dither: float  # amplitude that the spool's opening is dithered with, share of full opening
    follow: float  # L, 1/s
    smoothing: float  # time over which the residual is averaged, s
    fastest: float  # faster than that no joint turns: an angle that jumps is the sensor's, rad/s


class AirEstimate(NamedTuple):
    """What is known of a joint's air."""

    pressure_a: float  # Pa
    pressure_b: float  # Pa
    angle: float  # before, rad
    residual: float  # averaged
    taken: float = 0.0  # from the supply so far, kg


@law
def _conductance(parts, u):
    # Mean over the dither of what a path lets through that opens with u.
    share = mean_above_zero(u - parts.dither - parts.overlap, u + parts.dither - parts.overlap)
    share = min(share / (1.0 - parts.overlap), 1.0)
    through = parts.leakage + (parts.conductance - parts.leakage) * share
    # Valve and tube in series (ISO 6358-3).
    narrowed = through / parts.line_conductance
    return through / sqrt(1.0 + narrowed * narrowed)


@law
def _passes(parts, p, p_e):
    # Mean of the pressure that drives flow from p to p_e, below zero where it flows the other way.
    drives = effective_pressure(max(p, p_e), min(p, p_e), parts.critical_ratio, parts.laminar_slope)
    return drives if p >= p_e else -drives


@law
def _inflow(come, go, fills, vents):
    return REFERENCE_PRESSURE * (fills * come - vents * go)


@law
def follow_air(parts, estimate, opening, angle, difference, supply, exhaust, elapsed):
    """Estimate after a cycle of `elapsed` seconds in which the valve was asked for `opening`.

    Args: `AirParts`, `AirEstimate`, opening, angle now (rad), differential pressure now (Pa), absolute pressures of the
    supply and of the exhaust (Pa), s.
    """
    K, h = parts.torque_constant, min(elapsed, LONGEST) / SUBSTEPS
    velocity = min(max((angle - estimate.angle) / elapsed, -parts.fastest), parts.fastest)
    volume_a = max(parts.dead_volume + K * (parts.neutral + angle), 0.5 * parts.dead_volume)
    volume_b = max(parts.dead_volume + K * (parts.neutral - angle), 0.5 * parts.dead_volume)
    fills, vents = _conductance(parts, opening), _conductance(parts, -opening)
    p_a, p_b, led, taken = estimate.pressure_a, estimate.pressure_b, 0.0, estimate.taken
    for _ in range(SUBSTEPS):
        pull = 0.5 * parts.follow * (difference - (p_a - p_b))
        led += pull
        come_a, go_a = _passes(parts, supply, p_a), _passes(parts, p_a, exhaust)
        come_b, go_b = _passes(parts, supply, p_b), _passes(parts, p_b, exhaust)
        taken += h * REFERENCE_DENSITY * (fills * max(come_a, 0.0) + vents * max(come_b, 0.0))
        p_a += h * ((_inflow(come_a, go_a, fills, vents) - p_a * K * velocity) / volume_a + pull)
        p_b += h * ((_inflow(come_b, go_b, vents, fills) + p_b * K * velocity) / volume_b - pull)
        p_a, p_b = max(p_a, 0.5 * exhaust), max(p_b, 0.5 * exhaust)
    full = REFERENCE_PRESSURE * parts.conductance * supply * 0.5 * (1.0 / volume_a + 1.0 / volume_b)
    share = elapsed / parts.smoothing
    residual = estimate.residual + min(share, 1.0) * (led / (SUBSTEPS * 0.5 * full) - estimate.residual)
    return AirEstimate(p_a, p_b, angle, residual, taken)
