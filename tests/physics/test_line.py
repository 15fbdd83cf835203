"""The tube between valve and hose: its formulas, and its numbers against a general solver on the same equations."""

from collections.abc import Callable
from math import log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from layflat.jit import kernel
from layflat.physics.air import CP, CV, GAMMA, GAS_CONSTANT, REFERENCE_DENSITY
from layflat.physics.flow import laminar_slope, orifice
from layflat.physics.line import (
    SPEED_OF_SOUND,
    LineAir,
    LineParameters,
    NoAir,
    NoLine,
    exchange_air,
    line_air,
    tube_conductance,
    tube_critical_ratio,
    tube_volume,
)
from layflat.physics.step import STEP
from layflat.sim.loop import Timing
from tests.physics.plants import AROUND, CYCLE, JOINTS, TWO_LINKS, VALVE, Run, kinetic_energy, run, signals

Floats = NDArray[np.float64]
FULL, LEAK, VOLUME = 2e-8, 8e-11, 3e-4  # conductances of the valve, m3/(s Pa), and volume of the hose, m3
SUPPLY, OUTSIDE, ROOM = AROUND.supply_pressure, AROUND.ambient_pressure, AROUND.ambient_temperature
VISCOSITY = 1.82e-5  # of air, Pa s


def tube(length: float, bore: float) -> LineParameters:
    through = tube_conductance(length, bore)
    ratio = tube_critical_ratio(through, bore)
    return LineParameters(tube_volume(length, bore), through, ratio, float(laminar_slope(ratio)), 0.3 * length)


def fanno(length: float, bore: float) -> tuple[float, float]:
    """Sonic conductance and critical ratio of an adiabatic smooth tube behind a frictionless inlet."""
    supply = 6e5

    def flow(mach: float) -> float:
        warm = 1.0 + 0.2 * mach * mach
        return float(supply / warm**3 * mach * sqrt(GAMMA / (GAS_CONSTANT * ROOM)) * 0.25 * pi * bore**2)

    def left(mach: float) -> float:
        reynolds = 4.0 * flow(mach) / (pi * bore * VISCOSITY)
        friction = 0.3164 / reynolds**0.25 if reynolds < 1e5 else 0.0032 + 0.221 / reynolds**0.237
        ways = (1.0 - mach**2) / (GAMMA * mach**2) + 2.4 / 2.8 * log(2.4 * mach**2 / (2.0 + 0.4 * mach**2))
        return float(ways - friction * length / bore)

    mach = float(brentq(left, 1e-3, 1.0 - 1e-9))
    end = (1.0 + 0.2 * mach**2) ** -3.5 * mach * sqrt((2.0 + 0.4 * mach**2) / 2.4)
    return flow(mach) / (REFERENCE_DENSITY * supply), end


def test_sound_is_as_fast_as_in_tables_of_air_at_20_degrees() -> None:
    assert pytest.approx(343.2, rel=1e-3) == SPEED_OF_SOUND


@pytest.mark.parametrize("length", [0.1, 0.5, 2.0, 5.0])
@pytest.mark.parametrize("bore", [2e-3, 4e-3, 8e-3, 12e-3])
def test_a_tube_lets_through_a_little_less_than_choked_flow_with_friction(length: float, bore: float) -> None:
    through = tube_conductance(length, bore)
    conductance, ratio = fanno(length, bore)
    assert 0.8 < through / conductance < 0.95, "inlet and outlet lose something too"
    assert tube_critical_ratio(through, bore) == pytest.approx(ratio, abs=0.12)


@kernel
def filled(line: Any, valve: Any, around: Any, opens: Any, vents: Any, h: float, y: Any) -> None:
    """Rows of y: energy and mass in the line, in a rigid hose without heat, and mass taken from the supply."""
    stiffness, change, gain = (1.4 - 1.0) / 3e-4, 0.0, 0.0
    for i in range(len(opens)):
        p_0 = stiffness * y[i, 2]
        p, m = p_0 + 0.5 * change, y[i, 3] + 0.5 * gain
        T = p * 3e-4 / (m * 287.05)
        air = LineAir(y[i, 0], y[i, 1])
        flow, heat, taken, air = exchange_air(
            line, air, valve, (opens[i], vents[i]), p, p_0, stiffness, T, 1.0 / T, 0.0, around, h
        )
        y[i + 1, 0], y[i + 1, 1] = air.energy, air.mass
        y[i + 1, 2], y[i + 1, 3], y[i + 1, 4] = y[i, 2] + h * heat, y[i, 3] + h * flow, y[i, 4] + h * taken
        change, gain = stiffness * h * heat, h * flow


class Filled(NamedTuple):
    """Pressures in line and hose (Pa), their masses (kg) and energies (J), and the mass taken from the supply (kg)."""

    line: Floats
    hose: Floats
    masses: Floats
    energies: Floats
    taken: Floats


def fill(line: LineParameters, opens: Floats, vents: Floats, h: float, pressure: float = 3e5) -> Filled:
    y = np.zeros((len(opens) + 1, 5))
    for at, volume in ((0, line.volume), (2, VOLUME)):
        y[0, at : at + 2] = pressure * volume / (GAMMA - 1.0), pressure * volume / (GAS_CONSTANT * ROOM)
    filled(line, VALVE, AROUND, opens, vents, h, y)
    return Filled(
        (GAMMA - 1.0) * y[:, 0] / line.volume, (GAMMA - 1.0) * y[:, 2] / VOLUME, y[:, 1:4:2], y[:, 0:3:2], y[:, 4]
    )


def swinging(t: Any) -> tuple[Any, Any]:
    swing = 0.6 * np.sin(2 * pi * 8.0 * t)
    return FULL * np.maximum(swing, 0.0) + LEAK, FULL * np.maximum(-swing, 0.0) + LEAK


def smooth(t: Any) -> tuple[Any, Any]:
    swing = np.sin(2 * pi * 12.0 * t)
    return FULL * (0.3 + 0.25 * swing), FULL * (0.2 - 0.15 * swing)


Drive = Callable[[Any], tuple[Any, Any]]


def reference(line: LineParameters, drive: Drive, seconds: float, instants: Floats) -> tuple[Floats, Floats]:
    """Pressures of line and hose by LSODA."""

    def rates(t: float, y: Floats) -> list[float]:
        p, T = (GAMMA - 1.0) * y[0] / line.volume, y[0] / (CV * y[1])
        p_h, T_h = (GAMMA - 1.0) * y[2] / VOLUME, y[2] / (CV * y[3])
        opens, vents = drive(t)
        path = VALVE.critical_ratio, VALVE.laminar_slope
        come, brings = orifice(opens, *path, SUPPLY, ROOM, p, T)
        go, takes = orifice(vents, *path, p, T, OUTSIDE, ROOM)
        on, leads = orifice(line.conductance, line.critical_ratio, line.laminar_slope, p, T, p_h, T_h)
        warms = line.wall_conductance * (ROOM - T)
        return [brings - takes - leads + warms, come - go - on, leads, on]

    y = [3e5 * line.volume / 0.4, 3e5 * line.volume / (GAS_CONSTANT * ROOM)]
    y += [3e5 * VOLUME / 0.4, 3e5 * VOLUME / (GAS_CONSTANT * ROOM)]
    found = solve_ivp(rates, (0.0, seconds), y, "LSODA", t_eval=instants, rtol=1e-8, atol=1e-14, max_step=5e-4)
    return 0.4 * found.y[0] / line.volume, 0.4 * found.y[2] / VOLUME


def errors(line: LineParameters, drive: Drive, steps: list[float]) -> list[float]:
    """Greatest errors of the hose's pressure, Pa."""
    seconds = 0.125
    instants = np.linspace(0.0, seconds, 251)
    _, hose = reference(line, drive, seconds, instants)
    assert np.ptp(hose) > 1e4
    worst = []
    for h in steps:
        t = h * (np.arange(round(seconds / h)) + 0.5)
        ours = fill(line, *drive(t), h)
        worst.append(float(np.abs(ours.hose[:: round(5e-4 / h)] - hose).max()))
    return worst


@pytest.mark.compiled
@pytest.mark.parametrize("bore", [2e-3, 4e-3, 12e-3])
@pytest.mark.parametrize("length", [0.05, 1.0, 5.0])
def test_the_default_step_is_fine_enough_for_any_tube(length: float, bore: float) -> None:
    # The hose's pressure changes by 0.1 to 1 bar; a count of a 12-bit sensor of 10 bar is 244 Pa.
    assert errors(tube(length, bore), swinging, [STEP])[0] < 50.0


@pytest.mark.compiled
@pytest.mark.parametrize(("length", "bore"), [(1.0, 4e-3), (3.0, 6e-3), (5.0, 2e-3)])
def test_second_order(length: float, bore: float) -> None:
    coarse, middle, fine = errors(tube(length, bore), smooth, [5e-4, 2.5e-4, 1.25e-4])
    assert coarse > middle > fine
    assert coarse / fine > 9.0


tubes = st.builds(tube, st.floats(0.05, 5.0), st.floats(2e-3, 12e-3))
openings = st.lists(st.tuples(st.sampled_from([0.0, 1.0, 0.01]), st.floats(0.0, 1.0)), min_size=1, max_size=6)


@settings(max_examples=40, deadline=None)
@given(tubes, openings, st.floats(1.02e5, 5e5), st.sampled_from([1e-4, 2.5e-4, 1e-3]))
def test_no_air_and_no_energy_is_lost_however_abruptly_the_valve_moves(
    line: LineParameters, moves: list[tuple[float, float]], pressure: float, h: float
) -> None:
    line = line._replace(wall_conductance=0.0)
    opens = np.repeat([FULL * x for x, _ in moves], 20)
    found = fill(line, opens, 0.0 * opens, h, pressure)
    # Shut towards the outside: what was taken is there.
    gained = found.masses.sum(axis=1) - found.masses[0].sum()
    assert gained == pytest.approx(found.taken, rel=1e-9, abs=1e-9 * found.masses[0].sum())
    energy = found.energies.sum(axis=1) - found.energies[0].sum()
    back = found.taken * CP * AROUND.supply_temperature
    filling = np.all(np.diff(found.taken) >= 0.0)
    assert not filling or energy == pytest.approx(back, rel=1e-9, abs=1e-9 * found.energies[0].sum())


@settings(max_examples=40, deadline=None)
@given(tubes, openings, st.floats(1.02e5, 5e5), st.sampled_from([1e-4, 2.5e-4, 1e-3]))
def test_pressures_stay_between_those_that_drive_them(
    line: LineParameters, moves: list[tuple[float, float]], pressure: float, h: float
) -> None:
    opens, vents = (np.repeat([FULL * move[i] for move in moves], 20) for i in (0, 1))
    found = fill(line, opens, vents, h, pressure)
    low, high = 0.97 * min(OUTSIDE, pressure), 1.03 * max(SUPPLY, pressure)
    assert np.all((found.hose > low) & (found.hose < high))
    assert np.all(found.masses > 0.0)
    warm = found.energies / (CV * found.masses)
    assert np.all((warm > 180.0) & (warm < 450.0))
    assert np.all(found.line > 0.5 * OUTSIDE)
    assert np.all(found.line < 1.1 * high)


def test_without_a_line_there_is_no_air_in_it() -> None:
    assert line_air(NoLine(), 3e5, ROOM) == NoAir()
    held = line_air(tube(1.0, 4e-3), 3e5, ROOM)
    assert held.mass == pytest.approx(3e5 * 12.566e-6 / (GAS_CONSTANT * ROOM), rel=1e-3)
    assert held.energy == pytest.approx(CV * ROOM * held.mass)


def lined(length: float, bore: float) -> tuple[Any, ...]:
    line = tube(length, bore)
    return tuple(
        joint._replace(hose_a=joint.hose_a._replace(line=line), hose_b=joint.hose_b._replace(line=line))
        for joint in JOINTS
    )


def swung(length: float, bore: float, steps: int = 20) -> Run:
    t = np.arange(400) * CYCLE
    opening = np.stack([0.3 * np.sin(4.4 * t), 0.2 * np.sin(6.9 * t)], axis=1)
    acting = signals(len(t), 2, opening=opening, brake=[6.7, 2.2], payload=1.5)
    return run(TWO_LINKS, lined(length, bore), acting, Timing(CYCLE, steps, 1))


ANY = pytest.mark.parametrize(("length", "bore"), [(0.05, 2e-3), (1.0, 4e-3), (1.0, 12e-3), (5.0, 12e-3)])


@pytest.mark.compiled
@ANY
def test_the_default_step_is_fine_enough_for_an_arm(length: float, bore: float) -> None:
    apart = swung(length, bore).column("angle") - swung(length, bore, 320).column("angle")
    assert np.degrees(np.sqrt(np.mean(apart**2, axis=0))).max() < 0.015


@pytest.mark.compiled
@ANY
def test_the_ledger_of_an_arm_closes_with_any_tube(length: float, bore: float) -> None:
    done = swung(length, bore)
    book = {name: done.column(name).sum(axis=1) for name in ("gas_work", "load_work", "hose_work")}
    heat = done.column("brake_heat").sum(axis=1) + done.column("damping_heat").sum(axis=1)
    kinetic = kinetic_energy(TWO_LINKS, 1.5, done.column("angle"), done.column("velocity"))
    missing = book["gas_work"] + book["load_work"] - book["hose_work"] - heat - kinetic
    assert np.abs(missing).max() < 1e-3 * np.abs(book["gas_work"]).max()
    assert np.degrees(np.ptp(done.column("angle"), axis=0)).min() > 1.0


@pytest.mark.compiled
def test_a_thin_tube_makes_an_arm_slower() -> None:
    acting = signals(40, 2, opening=np.full((40, 2), 0.5), brake=[6.7, 2.2], payload=1.5)
    turned = [run(TWO_LINKS, lined(1.0, bore), acting).column("angle")[-1, 0] for bore in (2e-3, 3e-3, 8e-3)]
    assert 0.0 < turned[0] < turned[1] < turned[2]
