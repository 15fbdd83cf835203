"""Joints with a single hose, and springs."""

import numpy as np
import pytest

from layflat.description.change import changed
from layflat.errors import MachineError
from layflat.lanes import leaves
from layflat.machine import Machine, load, parameters
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.motion.limits import arm_limits, static_torques
from layflat.physics.joint import SecondHose, TwoHoses, pressures_at_rest

LIFT = load("single-joint-lift")


def mixed(**small: object) -> Machine:
    """The paper's arm with something else about its small joint."""
    plain, sources = tables("paper-arm-fast")
    joints = {**plain["joint"], "small": {**plain["joint"]["small"], **small}}
    return build({**plain, "joint": joints}, sources, "mixed")


def test_joints_beside_each_other_have_parameters_of_one_kind() -> None:
    first, second = parameters.joints(mixed(acting="single", spring={"torque": "-9 N m"}))
    assert (first.second, second.second) == (SecondHose(1.0), SecondHose(0.0))
    assert (first.spring.torque, second.spring.torque) == (0.0, -9.0)
    assert {joint.second for joint in parameters.joints(mixed())} == {TwoHoses()}
    assert len(set(map(len, map(list, map(leaves, (first, second)))))) == 1


def test_one_pressure_can_not_choose_torque_and_stiffness() -> None:
    with pytest.raises(MachineError, match="regulator needs two hoses: the pressure in a single one is its torque"):
        mixed(acting="single", regulator={"min_fraction": 0.3, "stroke_time": "50 ms"})


def test_the_air_holds_what_the_spring_does_not() -> None:
    (joint,), around = parameters.joints(LIFT), parameters.surroundings(LIFT)
    q, pull = np.array([[0.4]]), np.array([[-4.0]])
    (needed,) = static_torques(LIFT, pull, q)[0]
    assert needed == pytest.approx(4.0 + 9.0 + 1.5 * 0.4)
    p_1, p_2 = pressures_at_rest(joint, 0.4, -4.0, around)
    assert p_2 == around.ambient_pressure
    K = parameters.torque_constant(next(iter(LIFT.joints.values())))
    assert K * (p_1 - p_2) == pytest.approx(needed, rel=1e-3)
    # More than there is, or less than nothing, can't be held.
    assert pressures_at_rest(joint, 0.0, -40.0, around)[0] == around.supply_pressure
    assert pressures_at_rest(joint, 0.0, 40.0, around)[0] == around.ambient_pressure


def test_a_single_hose_brings_its_joint_back_no_faster_than_what_pulls_it() -> None:
    here, there = np.array([-0.5]), np.array([0.5])
    (usual,), (stronger,) = (
        arm_limits(changed(LIFT, "joint.small.spring.torque", torque), here, there).acceleration
        for torque in (-9.0, -10.0)
    )
    assert stronger > usual
    with pytest.raises(MachineError, match="can't hold"):
        arm_limits(changed(LIFT, "joint.small.spring.torque", 2.0), here, there)
