import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.control.tracking.auxiliary import has_stiffness, joint_stiffness, supply_share
from layflat.machine import load, parameters
from layflat.physics.flow import effective_pressure
from layflat.physics.joint import joint_at_rest

ARM = load("paper-arm-adjustable")
JOINTS, AROUND = parameters.joints(ARM), parameters.surroundings(ARM)


@given(st.integers(0, 1), st.floats(-0.8, 0.8), st.floats(1.3e5, 5.5e5))
def test_the_supply_for_a_stiffness_lets_as_much_in_as_out_at_its_pressure(j: int, q: float, p: float) -> None:
    joint, p_a = JOINTS[j], AROUND.ambient_pressure
    k = joint_stiffness(joint, q, p, p, p_a)
    # Where the pressure is already there, nothing is led beyond it.
    share = supply_share(joint, joint_at_rest(joint, q, p, p, AROUND), q, k, AROUND)
    p_s = p_a + share * (AROUND.supply_pressure - p_a)
    b, s = joint.valve.critical_ratio, joint.valve.laminar_slope
    assert effective_pressure(p_s, p, b, s) == pytest.approx(effective_pressure(p, p_a, b, s), rel=0.03)


@given(st.integers(0, 1), st.floats(-0.8, 0.8), st.floats(1.2e5, 5e5))
def test_it_grows_with_pressure(j: int, q: float, p: float) -> None:
    found = [joint_stiffness(JOINTS[j], q, each, each, AROUND.ambient_pressure) for each in (p, 1.1 * p)]
    assert found[0] < found[1] < 1.15 * found[0]


def test_pressures_that_are_too_high_call_for_less_supply_but_no_less_than_the_hoses_have() -> None:
    joint = JOINTS[1]
    k = joint_stiffness(joint, 0.0, 2e5, 2e5, AROUND.ambient_pressure)
    share = supply_share(joint, joint_at_rest(joint, 0.0, 4e5, 4.2e5, AROUND), 0.0, k, AROUND)
    assert share == pytest.approx(
        (4.2e5 - AROUND.ambient_pressure) / (AROUND.supply_pressure - AROUND.ambient_pressure)
    )


def test_what_is_out_of_reach_is_near_at_the_limits_of_the_supply() -> None:
    joint, p_a, p_s = JOINTS[0], AROUND.ambient_pressure, AROUND.supply_pressure

    def near(p: float, k: float) -> bool:
        return bool(has_stiffness(joint, joint_at_rest(joint, 0.0, p, p, AROUND), k, AROUND))

    assert near(3e5, 0.0)
    assert near(3e5, joint_stiffness(joint, 0.0, 3e5, 3e5, p_a))
    assert not near(3e5, 1.0)
    assert not near(3e5, 1e4)
    assert near(p_a + 0.005 * (p_s - p_a), 1.0)
    assert near(0.76 * p_s, 1e4)
