import pytest

from layflat.errors import MachineError
from layflat.experiments import load_bench
from layflat.experiments.axis_one import max_settling_inertia
from layflat.experiments.bench import RIG_NAMES, isolate_joint, maximum_torque, payload_for_inertia
from layflat.machine import changed, load


def test_inertia_and_payload() -> None:
    assert payload_for_inertia(load("paper-small-joint"), "small", 0.32) == pytest.approx(2.0)


def test_axis_one_and_the_earlier_actuator_share_a_controller_scaled_to_torque() -> None:
    on = load_bench()
    own, scaled = on.axis_one.joint["small"].gains, on.earlier_scaled.joint["small"].gains
    assert own is not None
    assert scaled is not None
    ratio = maximum_torque(on.earlier, "small") / maximum_torque(on.arm, "small")
    assert scaled.far.error == own.far.error
    assert scaled.far.pressure == pytest.approx(ratio * own.far.pressure)


def test_gains_tuned_for_the_arm_do_not_touch_axis_one() -> None:
    arm = load("paper-arm")
    tuned = changed(arm, "joint.small.gains.close.error", 100.0)
    assert load_bench(tuned).axis_one == load_bench(arm).axis_one
    assert load_bench(tuned).earlier_scaled == load_bench(arm).earlier_scaled


def test_a_limit_ends_at_the_first_inertia_that_takes_too_long() -> None:
    times = {1.0: 0.5, 2.0: 1.4, 3.0: 2.5, 4.0: 1.0}
    assert max_settling_inertia(times, 1.5) == 2.0
    assert max_settling_inertia(times, 3.0) == 4.0
    assert max_settling_inertia(times, 0.1) == 0.0


def test_what_a_machine_lacks_is_named() -> None:
    with pytest.raises(MachineError, match="paper-small-joint: has no joint 'large'"):
        load_bench("paper-small-joint").joint("large")
    with pytest.raises(MachineError, match="paper-large-joint: has no joint 'small'"):
        _ = load_bench("paper-large-joint").axis_one
    with pytest.raises(MachineError, match="paper-arm-switching: has no spool valve"):
        _ = load_bench("paper-arm-switching").valve


def test_a_joint_alone_keeps_what_it_is() -> None:
    arm = load("paper-arm")
    one = isolate_joint(arm, "large", 0.7)
    assert (one.arm.joints, one.arm.payload) == (("large",), 0.7)
    assert one.joint["large"] == arm.joint["large"]
    assert load_bench().axis_one.arm.payload == 2.0


def test_the_rigs_of_the_papers_figures_act_one_way() -> None:
    rigs = load_bench().rigs
    assert list(rigs) == list(RIG_NAMES)
    assert {rig.joint["small"].acting for rig in rigs.values()} == {"single"}


def test_a_machine_with_another_controller_is_refused() -> None:
    with pytest.raises(
        MachineError, match="'tracking', but the reproduction of the paper needs the gains of the paper's law"
    ):
        load_bench("paper-arm-tracking")
