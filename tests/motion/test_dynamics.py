"""Torques of motions against what does not know the arm's laws: levers, and the energy that they give."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from layflat.description.change import changed
from layflat.machine import Machine, load
from layflat.machine.parameters import arm, mass_and_pull
from layflat.motion.dynamics import min_inertias, path_torques, rigid_torques
from layflat.motion.path import JointLine
from layflat.motion.trajectory import States
from tests.physics.arms.chain.chains import random_arm

PICKING, PENDULUM = load("picking-arm"), load("paper-small-joint")
PAYLOAD, SHORT = 0.8, 1e-4


def still(*angles: float) -> States:
    at = np.array([angles])
    return States(at, 0.0 * at, 0.0 * at)


def kinetic(machine: Machine, q: np.ndarray, v: np.ndarray) -> float:
    return float(0.5 * v @ mass_and_pull(arm(machine), PAYLOAD, q.tolist())[0] @ v)


@pytest.mark.parametrize(
    "machine",
    [
        load("paper-arm"),
        changed(load("paper-arm"), "arm.gravity", 9.81),
        changed(load("paper-small-joint"), "arm.gravity", 9.81),
        random_arm(4, 3),
    ],
    ids=["level", "upright", "one-link", "in-space"],
)
def test_the_power_of_the_torques_is_what_the_arm_gains(machine: Machine) -> None:
    draw = np.random.default_rng(1)
    for _ in range(5):
        q, v, a = draw.normal(size=(3, len(machine.joints)))
        after, before = (kinetic(machine, q + t * v + 0.5 * t * t * a, v + t * a) for t in (SHORT, -SHORT))
        fallen = mass_and_pull(arm(machine), PAYLOAD, q.tolist())[1] @ v
        torques = rigid_torques(machine, States(q[None], v[None], a[None]), PAYLOAD)[0]
        assert torques @ v == pytest.approx((after - before) / (2.0 * SHORT) - fallen, rel=1e-5, abs=1e-6)


def test_a_weight_is_held_up_as_by_a_lever() -> None:
    joint = PENDULUM.joint["small"].planar_link
    hanging = changed(PENDULUM, "arm.gravity", 9.81)
    (torque,) = rigid_torques(hanging, still(0.5 * np.pi - float(hanging.arm.gravity_direction)), 2.0)[0]
    assert abs(torque) == pytest.approx(9.81 * (joint.mass * joint.centre + 2.0 * joint.length))
    # The wrist's link lies level at this posture; positive angles lift.
    level = still(0.0, 0.0, 0.0, np.radians(30.0))
    with_it, without = (rigid_torques(PICKING, level, payload)[0, 3] for payload in (1.0, 0.0))
    assert with_it - without == pytest.approx(9.81 * 0.18)


def test_a_path_asks_for_what_its_motion_does() -> None:
    path = JointLine(np.array([-0.5, 0.3, -0.2, 0.4]), np.array([0.6, -0.4, 0.5, -0.3]))
    s = np.linspace(0.1, 0.6, 7)
    q, first, second = path.evaluate(s)
    asked = path_torques(PICKING, path, s, 0.4)
    speed, pull = 0.8, -1.7
    states = States(q, speed * first, pull * first + speed**2 * second)
    whole = pull * asked.mass + speed**2 * asked.centrifugal + asked.gravity
    assert_allclose(whole, rigid_torques(PICKING, states, 0.4), atol=1e-12)


def test_a_torque_on_one_joint_meets_its_least_inertia_while_the_others_are_free() -> None:
    draw = np.random.default_rng(2)
    postures = draw.uniform(-1.0, 1.0, (4, 4))
    found = min_inertias(PICKING, postures, PAYLOAD)
    met = np.empty((4, 4))
    for posture, row in zip(postures, met, strict=True):
        mass = mass_and_pull(arm(PICKING), PAYLOAD, posture.tolist())[0]
        for j, torque in enumerate(np.eye(4)):
            row[j] = 1.0 / np.linalg.solve(mass, torque)[j]
    assert_allclose(found, met.min(axis=0), rtol=1e-9)
    assert np.all(found < np.diag(mass))
