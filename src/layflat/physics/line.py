"""The tube between a valve and its hose: an air space at the valve, and a resistance to the hose behind it.

| symbol | meaning | unit |
|---|---|---|
| E, m | energy and mass of the air at the valve's end of the tube | J, kg |
| V | its volume | m3 |
| p, p_h | absolute pressures of this air and in the hose | Pa |
| T, T_h | temperatures | K |
| x | p at the end of a step, as far as it is known | Pa |
| H | enthalpy flow: from the supply, to the exhaust, to the hose | W |
| G | enthalpy flow per pressure of choked flow | W/Pa |
| C, b, s | sonic conductance, critical pressure ratio, laminar slope (see flow.py) | m3/(s Pa), 1, 1 |
| k, k_h | rise of pressure per energy, of this air and of the hose's | Pa/J |
| D | drop of pressure over 1 - b | Pa |

Short tubes are stiff: their air answers within microseconds. A stage is an implicit Euler step, in which the valve's
paths have the flow per difference of pressure that they begin with, and the tube's own flow solves its law exactly; a
step is twice the result of two half stages less that of a whole one, which is of second order and keeps nothing of what
dies out within a step. Every flow is booked where it comes from and where it goes, so that no air and no energy is
lost. Derived in docs/derivations.md.
"""

from math import pi, sqrt
from typing import Any, NamedTuple

from layflat.jit import by_kind, law
from layflat.lanes import select
from layflat.physics.air import CP, CV, GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.flow import root_temperature
from layflat.physics.ramp import TINY
from layflat.physics.valves import chamber_flow

SPEED_OF_SOUND = sqrt(GAMMA * GAS_CONSTANT * REFERENCE_TEMPERATURE)
"""How fast a change of pressure comes through a tube, m/s."""

CHOKED = REFERENCE_DENSITY * CP * REFERENCE_TEMPERATURE
"""Enthalpy flow per sonic conductance and pressure, at the reference temperature, J/m3."""


class NoLine(NamedTuple):
    """A valve that sits on its hose."""


class Line(NamedTuple):
    """Parameters of a tube (units as in the module's table), with the heat flow from its wall per kelvin (W/K)."""

    volume: float
    conductance: float
    critical_ratio: float
    laminar_slope: float
    wall_conductance: float


class NoAir(NamedTuple):
    """The air in a line that is not there."""


class LineAir(NamedTuple):
    """State of a line: energy (J) and mass (kg) of the air at the valve's end."""

    energy: float
    mass: float


class Flows(NamedTuple):
    """Flows into the hose (J, kg) and out of the supply (kg)."""

    energy: float
    mass: float
    taken: float


def tube_conductance(length: float, bore: float) -> float:
    """Return the sonic conductance of a smooth tube (m), m3/(s Pa). Source: beater2007, after Eckersten."""
    return 0.029 * bore * bore / sqrt(length / bore**1.25 + 510.0)


def tube_critical_ratio(conductance: float, bore: float) -> float:
    """Return the critical pressure ratio of a tube with this sonic conductance. Source: beater2007, after Eckersten."""
    return 474.0 * conductance / (bore * bore)


def tube_volume(length: float, bore: float) -> float:
    """Return the volume of a tube, m3."""
    return 0.25 * pi * bore * bore * length


@law
def _no_air(line, p, T):  # noqa: ARG001
    return NoAir()


@law
def _air(line, p, T):
    return LineAir(p * line.volume / (GAMMA - 1.0), p * line.volume / (GAS_CONSTANT * T))


air_at = by_kind({NoLine: _no_air, Line: _air})
"""Air of a line at a pressure (Pa) and a temperature (K): `air_at(line, p, T)`."""


@law
def _ellipse(b, p_1, p_2):
    # p_1 phi(p_2/p_1) of flow.py before its chord, with the pressures in either order, and their difference.
    high, low = max(p_1, p_2), min(p_1, p_2)
    z = max(low - b * high, 0.0) * (1.0 / (1.0 - b))
    return sqrt(max(high * high - z * z, 0.0)), high - low + TINY


@law
def _through(G, b, s, p, falls, drop, answers):
    # Enthalpy flow through a tube where both ends answer to it: upstream p falls by `falls` per flow, the drop of
    # pressure by `answers`. The ellipse of flow.py is then a quadratic; the choked flow and the chord are lines.
    a, c = drop * (1.0 / (1.0 - b)), answers * (1.0 / (1.0 - b))
    one, other = 1.0 + G * falls, 1.0 + G * s * answers
    per = 1.0 / (one * other)
    choked, chord = G * p * other * per, G * s * drop * one * per
    square, half, rest = 1.0 + G * G * c * (c - 2.0 * falls), G * (c * (p - a) + falls * a), a * (2.0 * p - a)
    root = sqrt(max(half * half + square * rest, 0.0))
    # Whichever form does not cancel.
    quotient = select(half > 0.0, rest, root - half) / (select(half > 0.0, half + root, square) + TINY)
    ellipse = select(a - c * choked >= p - falls * choked, choked, G * quotient)
    return min(ellipse, chord)


@law
def _stage(line, air, valve, C_in, C_out, p_h, k_h, T_h, wall_h, around, h):
    # State of the line and pressure of the hose after h seconds, and what flowed.
    p_s, p_a, T_s = around.supply_pressure, around.ambient_pressure, around.supply_temperature
    k = (GAMMA - 1.0) / line.volume
    p, T = k * air.energy, air.energy / (CV * air.mass)
    supply, hose = sqrt(T_s * (1.0 / REFERENCE_TEMPERATURE)), sqrt(T_h * (1.0 / REFERENCE_TEMPERATURE))
    inside = sqrt(T * (1.0 / REFERENCE_TEMPERATURE))
    b, s = valve.critical_ratio, valve.laminar_slope
    # What the valve's paths let through per difference of pressure.
    (fed, fall), (vented, rise) = _ellipse(b, p_s, p), _ellipse(b, p, p_a)
    per = 1.0 / (fall * rise)
    feeds = CHOKED * C_in * select(p_s >= p, supply, inside) * min(fed * rise * per, s)
    relieves = CHOKED * C_out * select(p >= p_a, inside, supply) * min(vented * fall * per, s)
    held = CV * air.mass
    warmed = line.wall_conductance * (around.ambient_temperature * held - air.energy)
    warmed = warmed / (held + h * line.wall_conductance)
    # Both ends as they would be without flow between them, and how they answer to it.
    falls = h * k / (1.0 + h * k * (feeds + relieves))
    alone, beyond = p + falls * (feeds * (p_s - p) - relieves * (p - p_a) + warmed), p_h + h * k_h * wall_h
    forward = alone >= beyond
    G = CHOKED * line.conductance * select(forward, inside, hose)
    flow = _through(
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
    # Air that leaves is as warm as what is left: implicit too, or a tube that is flushed many times a step ran dry.
    per_h, per_s = 1.0 / (CP * T_h), 1.0 / (CP * T_s)
    comes = (max(fed, 0.0) + max(-vented, 0.0)) * per_s + max(-flow, 0.0) * per_h
    goes = max(-fed, 0.0) + max(vented, 0.0) + max(flow, 0.0)
    per_l = (air.mass + h * comes) / (GAMMA * energy + h * goes)
    mass = GAMMA * energy * per_l
    passed = select(flow > 0.0, per_l, per_h) * flow
    taken = select(fed > 0.0, per_s, per_l) * fed
    return LineAir(energy, mass), beyond + h * k_h * flow, Flows(h * flow, h * passed, h * taken)


@law
def _through_line(line, air, valve, paths, p, p_0, stiffness, T, roots, wall, around, h):  # noqa: ARG001
    # A whole stage, then two half ones: a loop, or the stage would be compiled three times.
    (C_in, C_out), begun, p_h, step, flows_count, air_counts = paths, air, p_0, h, -1.0, -1.0
    zero = 0.0 * p_0
    energy, mass, taken, left, kept = zero, zero, zero, zero, zero
    for i in range(3):
        begun, p_h, flows = _stage(line, begun, valve, C_in, C_out, p_h, stiffness, T, wall, around, step)
        energy, mass = energy + flows_count * flows.energy, mass + flows_count * flows.mass
        taken = taken + flows_count * flows.taken
        left, kept = left + air_counts * begun.energy, kept + air_counts * begun.mass
        air_counts = 2.0 * i
        if i == 0:
            begun, p_h, step, flows_count = air, p_0, 0.5 * h, 2.0
    per = 1.0 / h
    return per * mass, per * energy, per * taken, LineAir(left, kept)


@law
def _straight(line, air, valve, paths, p, p_0, stiffness, T, roots, wall, around, h):  # noqa: ARG001
    supply = root_temperature(around.supply_temperature)
    flow, heat, taken = chamber_flow(
        valve, paths[0], paths[1], p, roots, around.supply_pressure, supply, around.ambient_pressure
    )
    return flow, heat, taken, air


exchange: Any = by_kind({NoLine: _straight, Line: _through_line})
"""Air between a valve and a hose in a step of h seconds.

`exchange(line, air, valve, paths, p, p_0, stiffness, T, roots, wall, around, h)` takes the line and its air; the valve
with the conductances of its paths, to supply and to exhaust; of the hose, its pressure in the middle of the step and
at its beginning (Pa), the rise of pressure per energy (Pa/J), temperature and its roots, heat flow from the wall (W).
It yields the mean mass flow (kg/s) and enthalpy flow (W) into the hose, the mean mass flow taken from the supply
(kg/s), and the air of the line after the step.
"""
