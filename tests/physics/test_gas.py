"""A chamber that is filled and vented through the valve, against SciPy and against the limits of thermodynamics."""

from math import sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layflat.physics.chamber import Chamber
from layflat.physics.hose import PolynomialStroke, swept_volume
from layflat.physics.joint import JointParameters
from layflat.physics.valves.spool_laws import Spool
from layflat.sim.loop import Timing
from tests.physics.plants import AROUND, CYCLE, LARGE, NO_LOSS, ONE_LINK, VALVE, Floats, Run, run, signals

pytestmark = pytest.mark.compiled

R_AIR, GAMMA, RHO_0, T_0 = 287.05, 1.4, 1.185, 293.15
LOCKED = 1e6
SMOOTH = VALVE._replace(spool=Spool(500.0, 0.7, 0.0), dither_amplitude=0.0, overlap=0.0)
OPENING = np.concatenate([np.full(60, 0.3), np.full(60, -0.4), np.full(80, 0.05)])


def locked_joint(conductance: float, compliance: float = 0.0) -> JointParameters:
    """A joint whose brake never lets go, with hoses of this wall conductance (W/K) and compliance (m3/Pa)."""
    hose = LARGE.hose_a._replace(chamber=Chamber(1.2e-4, compliance, conductance), loss=NO_LOSS)
    return LARGE._replace(hose_a=hose, hose_b=hose, valve=SMOOTH)


def locked_run(joint: JointParameters, opening: Floats, steps: int = 20) -> Run:
    acting = signals(len(opening), 1, opening=opening[:, None], brake=LOCKED)
    done = run(ONE_LINK, (joint,), acting, Timing(CYCLE, steps, 1), pressure=2e5)
    assert np.all(done.column("angle") == 0.0)
    return done


def reference(conductance: float, opening: Floats) -> Floats:
    """Pressure and temperature of both hoses by an independent set of equations (instants, 4)."""
    V = 1.2e-4 + float(swept_volume(LARGE.hose_a.stroke, LARGE.hose_a.neutral))
    cv = R_AIR / (GAMMA - 1)
    p_s, T_s, p_a, T_w = AROUND[:4]

    def orifice(C: float, p_1: float, T_1: float, p_2: float, T_2: float) -> tuple[float, float]:
        if p_1 < p_2:
            back = orifice(C, p_2, T_2, p_1, T_1)
            return -back[0], -back[1]
        ratio, b = p_2 / p_1, SMOOTH.critical_ratio
        edge = sqrt(1 - ((0.999 - b) / (1 - b)) ** 2)
        phi = edge * (1 - ratio) / 0.001 if ratio > 0.999 else sqrt(1 - (max(ratio - b, 0.0) / (1 - b)) ** 2)
        flow = C * RHO_0 * p_1 * phi * sqrt(T_0 / T_1)
        return flow, flow * cv * GAMMA * T_1

    def chamber(x: float, m: float, T: float) -> tuple[float, float]:
        p = m * R_AIR * T / V
        C_in, C_out = (SMOOTH.leakage + (SMOOTH.conductance - SMOOTH.leakage) * max(s, 0.0) for s in (x, -x))
        (m_in, h_in), (m_out, h_out) = orifice(C_in, p_s, T_s, p, T), orifice(C_out, p, T, p_a, T_s)
        dm = m_in - m_out
        return dm, (h_in - h_out + conductance * (T_w - T) - cv * T * dm) / (m * cv)

    def rates(_t: float, y: Floats, u: float) -> list[float]:
        x, v, m_a, T_a, m_b, T_b = y
        wn, zeta = SMOOTH.spool.natural_frequency, SMOOTH.spool.damping_ratio
        return [v, wn**2 * (u - x) - 2 * zeta * wn * v, *chamber(x, m_a, T_a), *chamber(-x, m_b, T_b)]

    m = 2e5 * V / (R_AIR * T_w)
    y = np.array([0.0, 0.0, m, T_w, m, T_w])
    path = [y]
    for u in opening:
        y = solve_ivp(rates, (0.0, CYCLE), y, args=(u,), rtol=1e-9, atol=1e-12, method="LSODA").y[:, -1]
        path.append(y)
    states = np.array(path)
    return np.column_stack(
        [states[:, 2] * R_AIR * states[:, 3] / V, states[:, 4] * R_AIR * states[:, 5] / V, states[:, 3], states[:, 5]]
    )


def test_filling_and_venting_agrees_with_scipy() -> None:
    expected = reference(1.0, OPENING)
    assert np.ptp(expected[:, 0]) > 1.5e5
    assert np.ptp(expected[:, 2]) > 30.0
    errors = []
    for steps in (20, 40):
        done = locked_run(locked_joint(1.0), OPENING, steps)
        names = ("pressure_a", "pressure_b", "temperature_a", "temperature_b")
        ours = np.column_stack([done.column(name)[:, 0] for name in names])
        errors.append(np.abs(ours - expected).max(axis=0))
    # Pa and K, at the default step.
    assert np.all(errors[0][:2] < 5.0)
    assert np.all(errors[0][2:] < 0.005)
    assert np.all(errors[1] < 0.4 * errors[0])


def test_a_good_conductor_is_isothermal() -> None:
    done = locked_run(locked_joint(100.0), np.full(200, 0.02))
    assert done.column("temperature_a") == pytest.approx(T_0, abs=0.5)


def test_without_heat_flow_venting_is_adiabatic() -> None:
    done = locked_run(locked_joint(0.0)._replace(valve=SMOOTH._replace(leakage=0.0)), np.full(100, -0.2))
    p, T = done.column("pressure_a")[:, 0], done.column("temperature_a")[:, 0]
    assert p[-1] < 0.75 * p[0]
    assert T == pytest.approx(T_0 * (p / p[0]) ** ((GAMMA - 1) / GAMMA), rel=1e-4)


@pytest.mark.parametrize("opening", [-1.0, 1.0])
def test_pressure_ends_at_supply_or_ambient_and_never_beyond(opening: float) -> None:
    done = locked_run(locked_joint(1.0, 2e-11), np.full(600, opening))
    pressures = np.column_stack([done.column("pressure_a"), done.column("pressure_b")])
    assert pressures.max() <= AROUND.supply_pressure * (1 + 1e-6)
    assert pressures.min() >= AROUND.ambient_pressure * (1 - 1e-6)
    fed, vented = pressures[-1] if opening > 0 else pressures[-1, ::-1]
    assert fed == pytest.approx(AROUND.supply_pressure, rel=0.01)
    assert vented == pytest.approx(AROUND.ambient_pressure, rel=0.03)


def test_air_taken_from_the_supply_is_air_gained_and_lost() -> None:
    done = locked_run(locked_joint(1.0)._replace(valve=SMOOTH._replace(leakage=0.0)), np.full(50, 0.3))
    V = 1.2e-4 + float(swept_volume(PolynomialStroke(2.05e-4, 0.0, 0.0, 0.0, 0.0), LARGE.hose_a.neutral))
    mass = done.column("pressure_a")[:, 0] * V / (R_AIR * done.column("temperature_a")[:, 0])
    assert done.column("air_taken")[:, 0] == pytest.approx(mass - mass[0], rel=1e-6, abs=1e-12)
