"""Tube between a valve and its hose: an air space at the valve, and a flow resistance to the hose.

| symbol | meaning | unit |
|---|---|---|
| E, m | energy and mass of the air at the valve's end of the tube | J, kg |
| V | its volume | m3 |
| p, p_h | absolute pressures of this air and in the hose | Pa |
| T, T_h | temperatures | K |
| x | p at the end of a step | Pa |
| H | enthalpy flow: from the supply, to the exhaust, to the hose | W |
| G | enthalpy flow per pressure of choked flow | W/Pa |
| C, b, s | sonic conductance, critical pressure ratio, laminar slope (see flow.py) | m3/(s Pa), 1, 1 |
| k, k_h | pressure rise per energy, of this air and of the hose's | Pa/J |
| D | pressure drop over 1 - b | Pa |

Short tubes are stiff: their air settles within microseconds. A stage is an implicit Euler step, in which the valve's
paths keep their initial flow per pressure difference, and the tube's own flow solves its law exactly; a step is twice
the result of two half stages minus that of a whole one (Richardson extrapolation), which is of second order and
L-stable. Every flow is subtracted at its source and added at its sink, so that air and energy are conserved. Derived in
docs/derivations.md.
"""

from math import pi, sqrt
from typing import Any, NamedTuple

from layflat.jit import by_kind, law
from layflat.lanes import select
from layflat.physics.air import CP, CV, GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.flow import root_temperature
from layflat.physics.ramp import QUOTIENT_FLOOR
from layflat.physics.valves import chamber_flow

SPEED_OF_SOUND = sqrt(GAMMA * GAS_CONSTANT * REFERENCE_TEMPERATURE)
"""Speed of sound at the reference temperature, m/s."""

CHOKED_ENTHALPY_FLOW = REFERENCE_DENSITY * CP * REFERENCE_TEMPERATURE
"""Enthalpy flow per sonic conductance and pressure, at the reference temperature, J/m3."""


class NoLine(NamedTuple):
    """No tube: a valve directly on its hose."""


class LineParameters(NamedTuple):
    """Parameters of a tube (units as in the module's table), with the heat flow from its wall per kelvin (W/K)."""

    volume: float
    conductance: float
    critical_ratio: float
    laminar_slope: float
    wall_conductance: float


class NoAir(NamedTuple):
    """State of no line."""


class LineAir(NamedTuple):
    """State of a line: energy (J) and mass (kg) of the air at the valve's end."""

    energy: float
    mass: float


class LineFlows(NamedTuple):
    """Energy (J) and mass (kg) into the hose, and mass out of the supply (kg), in a stage."""

    energy: float
    mass: float
    supplied: float


def tube_conductance(length: float, bore: float) -> float:
    """Return the sonic conductance of a smooth tube (m), m3/(s Pa). Source: beater2007, after Eckersten."""
    return 0.029 * bore * bore / sqrt(length / bore**1.25 + 510.0)


def tube_critical_ratio(conductance: float, bore: float) -> float:
    """Return the critical pressure ratio of a tube with this sonic conductance. Source: beater2007, after Eckersten."""
    return 474.0 * conductance / (bore * bore)


def tube_volume(length: float, bore: float) -> float:
    """Return the volume of a tube of a length and bore (m), m3."""
    return 0.25 * pi * bore * bore * length


@law
def _no_air(line, p, T):  # noqa: ARG001
    return NoAir()


@law
def _tube_air(line, p, T):
    return LineAir(p * line.volume / (GAMMA - 1.0), p * line.volume / (GAS_CONSTANT * T))


line_air = by_kind({NoLine: _no_air, LineParameters: _tube_air})
"""State of a line at a pressure (Pa) and a temperature (K): `line_air(line, p, T)`."""


@law
def _ellipse(b, p_1, p_2):
    """Return the greater pressure times phi of flow.py without its chord, and the difference, never 0, both Pa."""
    high, low = max(p_1, p_2), min(p_1, p_2)
    z = max(low - b * high, 0.0) * (1.0 / (1.0 - b))
    return sqrt(max(high * high - z * z, 0.0)), high - low + QUOTIENT_FLOOR


@law
def _tube_flow(G, b, s, p, falls, drop, answers):
    """Return the enthalpy flow (W) through a tube whose end pressures depend on it.

    Upstream p falls by `falls` per flow, the pressure drop by `answers`, both Pa/W. The ellipse of flow.py is then a
    quadratic; the choked flow and the chord are lines.
    """
    a, c = drop * (1.0 / (1.0 - b)), answers * (1.0 / (1.0 - b))
    choked_divisor, chord_divisor = 1.0 + G * falls, 1.0 + G * s * answers
    per = 1.0 / (choked_divisor * chord_divisor)
    choked, chord = G * p * chord_divisor * per, G * s * drop * choked_divisor * per
    square, half, rest = 1.0 + G * G * c * (c - 2.0 * falls), G * (c * (p - a) + falls * a), a * (2.0 * p - a)
    root = sqrt(max(half * half + square * rest, 0.0))
    # The form without cancellation.
    quotient = select(half > 0.0, rest, root - half) / (select(half > 0.0, half + root, square) + QUOTIENT_FLOOR)
    ellipse = select(a - c * choked >= p - falls * choked, choked, G * quotient)
    return min(ellipse, chord)


@law
def _euler_stage(line, air, valve, C_in, C_out, p_h, k_h, T_h, wall_h, around, h):
    """Return the air of the line, the pressure in the hose (Pa) and the flows of a stage of h seconds.

    C_in and C_out are the conductances of the valve's paths, wall_h the heat flow from the hose's wall, W.
    """
    p_s, p_a, T_s = around.supply_pressure, around.ambient_pressure, around.supply_temperature
    k = (GAMMA - 1.0) / line.volume
    p, T = k * air.energy, air.energy / (CV * air.mass)
    supply, hose = sqrt(T_s * (1.0 / REFERENCE_TEMPERATURE)), sqrt(T_h * (1.0 / REFERENCE_TEMPERATURE))
    inside = sqrt(T * (1.0 / REFERENCE_TEMPERATURE))
    b, s = valve.critical_ratio, valve.laminar_slope
    # Flow of the valve's paths per pressure difference.
    (fed, fall), (vented, rise) = _ellipse(b, p_s, p), _ellipse(b, p, p_a)
    per = 1.0 / (fall * rise)
    feeds = CHOKED_ENTHALPY_FLOW * C_in * select(p_s >= p, supply, inside) * min(fed * rise * per, s)
    relieves = CHOKED_ENTHALPY_FLOW * C_out * select(p >= p_a, inside, supply) * min(vented * fall * per, s)
    held = CV * air.mass
    warmed = line.wall_conductance * (around.ambient_temperature * held - air.energy)
    warmed = warmed / (held + h * line.wall_conductance)
    # Pressures at both ends without flow between them, and their change per flow.
    falls = h * k / (1.0 + h * k * (feeds + relieves))
    alone, beyond = p + falls * (feeds * (p_s - p) - relieves * (p - p_a) + warmed), p_h + h * k_h * wall_h
    forward = alone >= beyond
    G = CHOKED_ENTHALPY_FLOW * line.conductance * select(forward, inside, hose)
    flow = _tube_flow(
        G,
        line.critical_ratio,
        line.laminar_slope,
        max(alone, beyond),
        select(forward, falls, h * k_h),
        abs(alone - beyond),
        falls + h * k_h,
    )
    flow = select(forward, flow, -flow)
    x = alone - falls * flow
    fed, vented = feeds * (p_s - x), relieves * (x - p_a)
    energy = air.energy + h * (fed - vented - flow + warmed)
    # Leaving air has the temperature of the remaining air: implicit, or a tube flushed many times a step would run dry.
    per_h, per_s = 1.0 / (CP * T_h), 1.0 / (CP * T_s)
    comes = (max(fed, 0.0) + max(-vented, 0.0)) * per_s + max(-flow, 0.0) * per_h
    goes = max(-fed, 0.0) + max(vented, 0.0) + max(flow, 0.0)
    per_l = (air.mass + h * comes) / (GAMMA * energy + h * goes)
    mass = GAMMA * energy * per_l
    passed = select(flow > 0.0, per_l, per_h) * flow
    taken = select(fed > 0.0, per_s, per_l) * fed
    return LineAir(energy, mass), beyond + h * k_h * flow, LineFlows(h * flow, h * passed, h * taken)


@law
def _exchange_through_line(line, air, valve, paths, p, p_0, stiffness, T, roots, wall, around, h):  # noqa: ARG001
    """Return the mean flows of `exchange_air` through a tube, and its air after h.

    A whole stage, then two half ones: a loop, or the stage would be compiled three times.
    """
    (C_in, C_out), stage_air, p_h, step, flow_weight, air_weight = paths, air, p_0, h, -1.0, -1.0
    zero = 0.0 * p_0
    energy, mass, taken, end_energy, end_mass = zero, zero, zero, zero, zero
    for i in range(3):
        stage_air, p_h, flows = _euler_stage(line, stage_air, valve, C_in, C_out, p_h, stiffness, T, wall, around, step)
        energy, mass = energy + flow_weight * flows.energy, mass + flow_weight * flows.mass
        taken = taken + flow_weight * flows.supplied
        end_energy, end_mass = end_energy + air_weight * stage_air.energy, end_mass + air_weight * stage_air.mass
        air_weight = 2.0 * i
        if i == 0:
            stage_air, p_h, step, flow_weight = air, p_0, 0.5 * h, 2.0
    per = 1.0 / h
    return per * mass, per * energy, per * taken, LineAir(end_energy, end_mass)


@law
def _exchange_without_line(line, air, valve, paths, p, p_0, stiffness, T, roots, wall, around, h):  # noqa: ARG001
    """Return the mean flows of `exchange_air` where valve and hose are one, and the air of no line."""
    supply = root_temperature(around.supply_temperature)
    flow, heat, taken = chamber_flow(
        valve, paths[0], paths[1], p, roots, around.supply_pressure, supply, around.ambient_pressure
    )
    return flow, heat, taken, air


exchange_air: Any = by_kind({NoLine: _exchange_without_line, LineParameters: _exchange_through_line})
"""Flow of air between a valve and a hose in a step of h seconds.

`exchange_air(line, air, valve, paths, p, p_0, stiffness, T, roots, wall, around, h)` takes the line and its air; the
valve with the conductances of its paths, to supply and to exhaust; of the hose, its pressure in the middle of the step
and at its beginning (Pa), the pressure rise per energy (Pa/J), temperature and its roots, heat flow from the wall
(W). It yields the mean mass flow (kg/s) and enthalpy flow (W) into the hose, the mean mass flow taken from the supply
(kg/s), and the state of the line after the step.
"""
