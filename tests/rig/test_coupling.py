"""What joints at rest have to bear of others, against the laws of the arm."""

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.machine import parameters
from layflat.physics.arms import dynamics
from layflat.rig.safety.estimator import write_holding_torques
from tests.rig.hanging_arm import lifting_arm

ARM = parameters.arm(lifting_arm())


def at_rest(mass: Array, torques: Array, passive: Array, turns: list[float]) -> Array:
    n, out = len(torques), np.empty(len(torques))
    write_holding_torques(mass, torques, passive, np.array(turns), np.empty((n, n + 1)), out)
    return out


@pytest.mark.parametrize("turns", [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
def test_a_joint_that_bears_what_is_asked_of_it_stays_at_rest(turns: list[float]) -> None:
    q, v = (0.3, 0.6, -0.4), tuple(3.0 * turn for turn in turns)
    upper, swings, pulls = dynamics(ARM, 0.2, q, v)
    mass = np.zeros((3, 3))
    mass[np.triu_indices(3)] = upper
    mass += np.triu(mass, 1).T
    hoses, passive = np.array([2.0, -1.5, 0.7]), np.add(swings, pulls)
    asked = at_rest(mass, hoses + passive, passive, turns)
    for j in range(3):
        # Held by what is asked, it does not move while the others do; those that rest are held by their brakes.
        free = [i for i in range(3) if i != j and turns[i]]
        a = np.zeros(3)
        a[free] = np.linalg.solve(mass[np.ix_(free, free)], (hoses + passive)[free])
        assert asked[j] + passive[j] == pytest.approx((mass @ a)[j], abs=1e-12)


def test_of_two_joints_it_is_the_share_of_the_others_torque() -> None:
    mass = np.array([[0.6, 0.2], [0.2, 0.1]])
    assert at_rest(mass, np.array([3.0, 9.0]), np.zeros(2), [1.0, 0.0])[1] == pytest.approx(0.2 / 0.6 * 3.0)


def test_an_arm_at_rest_bears_gravity_alone() -> None:
    assert at_rest(np.eye(3), np.ones(3), np.array([0.5, -2.0, 0.0]), [0.0] * 3).tolist() == [-0.5, 2.0, 0.0]
