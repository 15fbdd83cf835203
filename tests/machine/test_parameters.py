from math import degrees, pi, radians

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from layflat.errors import MachineError
from layflat.experiments.bench import isolate_joint
from layflat.lanes import leaves
from layflat.machine import changed, load, parameters
from layflat.machine.exchanged import with_losses
from layflat.physics.arms.planar import LevelTwoLink, OneLink, TwoLink
from layflat.physics.hose import PolynomialStroke, roller_torque

ARM = load("paper-arm-fast")


def test_a_roller_follows_equation_1_closely() -> None:
    joint = load("rig-polyester").joint["small"]
    curve = Polynomial(parameters.stroke(joint))
    R, r, S = joint.cylinder.diameter / 2, joint.output.radius, parameters.full_travel(joint)
    for s in np.linspace(0.0, S, 37):
        alpha = joint.hose.wrap - s * r / (joint.hose.peel_ratio * R)
        exact = roller_torque(1.0, R, r, joint.hose.width / pi, joint.hose.wrap, alpha)
        assert curve(s) == pytest.approx(exact, rel=5e-6)


@pytest.mark.parametrize("name", ["large", "small"])
def test_a_cam_keeps_stroke_and_volume_of_its_roller(name: str) -> None:
    cam = ARM.joint[name]
    roller = changed(ARM, f"joint.{name}.output.kind", "roller").joint[name]
    S = parameters.full_travel(cam)
    swept = Polynomial(parameters.stroke(roller)).integ()(S)
    assert parameters.stroke(cam).k0 * S == pytest.approx(swept, rel=1e-6)
    assert cam.geometry.volume == pytest.approx(swept, rel=1e-6)


def test_strokes_of_the_paper() -> None:
    assert degrees(parameters.full_travel(ARM.joint["large"])) == pytest.approx(133.2, abs=0.5)
    assert parameters.torque_constant(ARM.joint["large"]) * 4e5 == pytest.approx(82.1, rel=0.005)


def test_a_single_acting_joint_has_no_second_hose() -> None:
    rig = load("rig-polyester").model_copy(update={"valve": ARM.valve})
    (joint,) = parameters.joints(rig)
    nothing = parameters.missing_hose(joint.hose_a)._replace(stroke=PolynomialStroke(0.0, 0.0, 0.0, 0.0, 0.0))
    assert joint.hose_b == nothing


def test_a_joint_with_a_cam_beside_one_with_a_roller_has_a_stroke_of_the_same_kind() -> None:
    mixed = changed(ARM, "joint.small.output.kind", "roller")
    large, small = parameters.joints(mixed)
    assert isinstance(large.hose_a.stroke, PolynomialStroke)
    assert isinstance(small.hose_a.stroke, PolynomialStroke)
    (even, _) = parameters.joints(ARM)
    assert large.hose_a.stroke == PolynomialStroke(even.hose_a.stroke.k0, 0.0, 0.0, 0.0, 0.0)


def test_arms_by_number_of_joints() -> None:
    assert isinstance(parameters.arm(ARM), LevelTwoLink)
    upright = changed(ARM, "arm.gravity", 9.81)
    assert isinstance(parameters.arm(upright), TwoLink)
    assert parameters.arm(upright)[:3] == parameters.arm(ARM)[:3]
    assert isinstance(parameters.arm(isolate_joint(ARM, "small", 2.0)), OneLink)


def test_two_links_with_a_locked_elbow_weigh_as_one() -> None:
    arm = parameters.arm(ARM)
    assert isinstance(arm, LevelTwoLink)
    large, small = ARM.joint["large"], ARM.joint["small"]
    far = np.hypot(large.planar_link.length, small.planar_link.centre)
    expected = (
        large.planar_link.rotor_inertia
        + large.planar_link.inertia
        + large.planar_link.mass * large.planar_link.centre**2
        + small.body.mass * large.planar_link.length**2
        + small.planar_link.rotor_inertia
        + small.planar_link.inertia
        + small.planar_link.mass * far**2
    )
    at_right_angle = arm.a + 2 * arm.b * np.cos(arm.elbow)
    assert at_right_angle == pytest.approx(expected, rel=1e-12)


def test_losses_add_up_to_the_described_share() -> None:
    joint = load("rig-polyester").joint["small"]
    loss, _ = parameters.loss(joint)
    at = joint.losses.reference_pressure_gauge
    limits = np.array(loss.base) + at * np.array(loss.slope)
    height = 2 * limits.sum() / (parameters.torque_constant(joint) * at)
    assert height == pytest.approx(parameters.loss_fraction(joint), rel=1e-12)


def test_rigs_without_valve_say_what_they_are_for() -> None:
    with pytest.raises(MachineError, match="layflat joint sweep"):
        parameters.joints(load("rig-polyester"))


def test_missing_gains_are_named() -> None:
    bare = changed(ARM, "joint.large.gains", None)
    with pytest.raises(MachineError, match=r"joint\.large\.gains: has no controller gains"):
        parameters.control(bare)


def test_angles_outside_the_stroke() -> None:
    assert parameters.check_inside_stroke(ARM, "large", radians(60), "x") == radians(60)
    with pytest.raises(MachineError, match=r"61 deg is outside the working stroke of joint 'large'; stay within \+-60"):
        parameters.check_inside_stroke(ARM, "large", radians(61), "x")
    with pytest.raises(MachineError):
        parameters.check_inside_stroke(ARM, "large", float("nan"), "x")


@pytest.mark.parametrize("name", ["rig-polyester", "paper-small-joint-fast"])
def test_a_torque_factor_that_differs_from_run_to_run(name: str) -> None:
    factors = np.array([0.8, 1.0, 1.3])
    many = changed(load(name), "joint.small.hose.torque_factor", factors)
    found = parameters.hose(many.joint["small"])
    for i, factor in enumerate(factors):
        one = parameters.hose(changed(load(name), "joint.small.hose.torque_factor", float(factor)).joint["small"])
        for part, own in ((found.stroke, one.stroke), (found.loss, one.loss)):
            numbers = [float(np.broadcast_to(number, 3)[i]) for number in leaves(part)]
            assert numbers == pytest.approx(list(leaves(own)), rel=1e-12)


def test_a_joint_may_have_a_larger_valve_than_the_others() -> None:
    arm, valve = changed(ARM, "joint.large.valve_size", 3.0), ARM.valve
    assert valve is not None
    large, small = (joint.valve for joint in parameters.joints(arm))
    assert large.conductance == 3.0 * small.conductance == 3.0 * valve.conductance
    assert large.leakage == 3.0 * small.leakage
    assert large._replace(conductance=0.0, leakage=0.0) == small._replace(conductance=0.0, leakage=0.0)
    air = parameters.air_observer_parameters(arm, "large"), parameters.air_observer_parameters(ARM, "large")
    assert air[0].conductance == 3.0 * air[1].conductance


BOUC_WEN = {"deflection": "2 deg", "beta": 0.6, "exponent": 1.0}


@pytest.mark.parametrize("machine", ["paper-arm", "paper-arm-tracking"])
@pytest.mark.parametrize(
    ("kind", "values"),
    [("bouc-wen", BOUC_WEN), ("elasto-slip", {"deflections": ["1 deg", "9 deg"], "weights": [0.5, 0.5]})],
)
def test_joints_with_unlike_losses_are_refused_in_one_line(machine: str, kind: str, values: dict[str, object]) -> None:
    one = with_losses(load(machine), kind, values, ["small"])
    with pytest.raises(MachineError, match=r"joint\.small: has losses .* than joint\.large; give all joints the same"):
        parameters.joints(one)
    assert parameters.joints(with_losses(load(machine), kind, values))
