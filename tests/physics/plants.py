"""Plants for the tests: small machines put together by hand, and short ways to run them."""

from math import pi, radians
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.control.paper.law import FeedbackGains, Gains, Report, Settings
from layflat.lanes import Like, leaves
from layflat.physics.arms.planar import OneLink, TwoLink
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope
from layflat.physics.friction.coulomb import Coulomb
from layflat.physics.hose import PolynomialStroke
from layflat.physics.hysteresis.elasto_slip import ElastoSlip
from layflat.physics.joint import HoseParameters, JointParameters, Surroundings
from layflat.physics.sensor import Sensor
from layflat.physics.stops_and_springs import StopParameters
from layflat.physics.valves.spool import SpoolValve
from layflat.physics.valves.spool_laws import Spool
from layflat.physics.valves.switching import Switch, SwitchingPair
from layflat.sim.kernel import COLUMNS, JointRecord, run_cycles
from layflat.sim.loop import Case, JointSignals, SharedSignals, Signals, Timing

Floats = NDArray[np.float64]

CYCLE = 0.005
SIGNALS = len(Report._fields)
DEFAULT = Timing(CYCLE, 20, 1)
AROUND = Surroundings(5.01e5, 293.15, 1.013e5, 293.15, 0.0)
FREE = StopParameters(radians(66.5), 50.0, radians(70.0), 2000.0, 5.0)
NO_STOPS = StopParameters(1e3, 0.0, 1e3, 0.0, 0.0)
NO_LOSS = ElastoSlip(*[(0.0, 0.0, 0.0)] * 3)
RIGID = Chamber(1.2e-4, 0.0, 1.0)
VALVE = SpoolValve(
    Spool(2 * pi * 80.0, 0.7, 0.05), 1.2e-8, 1.2e-10, 0.3, laminar_slope(0.3), 0.02, 5.0, 5.0, 0.12, 50.0, 0.0
)
PAIR = SwitchingPair(
    Switch(1.5e-3, 1e-3, 1e-3, 0.8e-3), 1.2e-8, 1.2e-10, 0.3, laminar_slope(0.3), 5.0, 5.0, 70.0, 0.01, 1.5e-3, 0.0
)
ANGLE_SENSOR = Sensor(-radians(75.0), radians(75.0), radians(150.0) / 4096, 0.0, 0.0)
PRESSURE_SENSOR = Sensor(-5e5, 5e5, 1e6 / 4096, 0.0, 0.0)
FAR, NEAR, CLOSE = (
    FeedbackGains(5.0 / radians(angle), k_p) for angle, k_p in ((12.0, 1.5e-5), (9.0, 1e-5), (6.0, 3e-6))
)
GAINS = Gains(
    *(FAR, NEAR, CLOSE, radians(8.0), radians(60.0), radians(1.5), radians(8.0), 5.0),
    *(20.0, 1.0, 10.0, 1.0, 500.0, radians(0.5), 0.0, 1e6, 0.0, 10.0, 1.0),
)
ONE_LINK = OneLink(0.32, 1.0, 0.4, 0.0, 0.0)
TWO_LINKS = TwoLink(0.46, 0.04, 0.025, 1.0, 0.1, 0.4, 0.4, radians(90.0), 0.0, 0.0)


def losses(torque: float) -> ElastoSlip:
    """Three elements that slip at `torque` N m in all at 4 bar, a quarter of it without pressure."""
    share = torque / 3.0
    stiffness = tuple(share / radians(angle) for angle in (2.0, 6.0, 15.0))
    return ElastoSlip(stiffness, (0.25 * share,) * 3, (0.75 * share / 4e5,) * 3)


def joint(K: float, dead_volume: float, compliance: float = 0.0) -> JointParameters:
    """A joint with constant K (m3/rad), dead volume (m3) and compliance (m3/Pa)."""
    hose = HoseParameters(
        PolynomialStroke(K, 0.0, 0.0, 0.0, 0.0),
        Chamber(dead_volume, compliance, 1.0),
        losses(0.035 * K * 4e5),
        radians(66.5),
    )
    return JointParameters(hose, hose, VALVE, FREE, 250.0 * K, 0.0, Coulomb(), ANGLE_SENSOR, PRESSURE_SENSOR)


LARGE, SMALL = joint(2.05e-4, 1.2e-4), joint(0.63e-4, 0.5e-4)
JOINTS = (LARGE, SMALL)
PASSIVE = LARGE._replace(
    hose_a=HoseParameters(PolynomialStroke(*[0.0] * 5), RIGID, NO_LOSS, 0.0),
    hose_b=HoseParameters(PolynomialStroke(*[0.0] * 5), RIGID, NO_LOSS, 0.0),
    stops=NO_STOPS,
    viscous_friction=0.0,
)
"""A joint without any torque of its own."""


class Run(NamedTuple):
    """Records of a run: every column of `Sample`, over instants and joints."""

    records: Floats

    def column(self, name: str) -> Floats:
        return np.asarray(self.records[:, :, JointRecord._fields.index(name)], dtype=np.float64)


def signals(cycles: int, joints: int, **given: Any) -> Signals:
    """Signals that are zero but for those given (which are spread over cycles and joints), at full supply."""
    p_a = AROUND.ambient_pressure
    usual = {"supply": AROUND.supply_pressure - p_a, "ambient": p_a, "dither": 1.0, "voltage": np.nan}
    by_joint = [np.broadcast_to((usual | given).get(name, 0.0), (cycles, joints)) for name in JointSignals._fields]
    shared = [np.broadcast_to((usual | given).get(name, 0.0), cycles) for name in SharedSignals._fields]
    return Signals(np.stack(by_joint, axis=-1), np.stack(shared, axis=-1))


def run(
    arm: OneLink | TwoLink,
    joints: tuple[JointParameters, ...],
    acting: Signals,
    timing: Timing = DEFAULT,
    angles: float | tuple[float, ...] = 0.0,
    pressure: float | tuple[tuple[float, float], ...] = 3.5e5,
) -> Run:
    """Run a plant from rest at these angles (rad) and pressures (absolute, Pa)."""
    n, calm = len(joints), np.zeros((len(acting.by_joint) + 1, len(joints), 2))
    joints = tuple(joint._replace(brake_torque=1.0) for joint in joints)  # so that shares of it are torques
    start = np.array(np.broadcast_to(angles, n), float)
    filled = np.array(np.broadcast_to(pressure, (n, 2)), float)
    case = Case(arm, joints, Settings((GAINS,) * n), AROUND)
    numbers = np.fromiter(leaves(case), float)
    seen = np.zeros(3, np.int64)
    rows = len(acting.by_joint) * timing.records + 1
    records, report = np.empty((rows, n, COLUMNS)), np.empty((rows, n, SIGNALS))
    run_cycles(Like.from_tuple(case), numbers, start, filled, acting, calm, timing, seen, records, report)
    assert seen[2] == -1
    return Run(records)


def kinetic_energy(arm: TwoLink, payload: float, angles: Floats, velocities: Floats) -> Floats:
    """Kinetic energy of a two-link arm from arrays (instants, 2), J."""
    q, v_1, v_2 = angles[:, 1] + arm.elbow, velocities[:, 0], velocities[:, 1]
    b = arm.b + payload * arm.length_1 * arm.length_2
    c = arm.c + payload * arm.length_2**2
    a = arm.a + payload * (arm.length_1**2 + arm.length_2**2)
    energy = 0.5 * ((a + 2 * b * np.cos(q)) * v_1**2 + 2 * (c + b * np.cos(q)) * v_1 * v_2 + c * v_2**2)
    return np.asarray(energy, dtype=np.float64)
