"""Torques that motions need, against the energy that they give."""

import numpy as np
import pytest
from chains import random_arm

from layflat.description.change import changed
from layflat.machine import Machine, load
from layflat.machine.parameters import arm, mass_and_pull
from layflat.motion.dynamics import rigid_torques
from layflat.motion.trajectory import States

PAYLOAD, SHORT = 0.8, 1e-4


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
