from math import radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.control.paper.law import FeedbackGains, Gains, Memory, Report, step_joint, wake_joint

CYCLE = 0.005
FAR, NEAR, CLOSE = FeedbackGains(20.0, 1.5e-5), FeedbackGains(30.0, 1e-5), FeedbackGains(50.0, 3e-6)
GAINS = Gains(
    far=FAR,
    near=NEAR,
    close=CLOSE,
    near_error=radians(8.0),
    near_speed=radians(60.0),
    close_error=radians(1.5),
    close_speed=radians(8.0),
    null=5.0,
    integral_gain=20.0,
    integral_limit=1.0,
    drift_time=10.0,
    drift_limit=0.8,
    air_ripple=500.0,
    rest_speed=radians(0.5),
    rest_time=0.05,
    load_pressure=5e4,
    voltage_low=0.0,
    voltage_high=10.0,
    averaged=1.0,
)
RIPPLE = 2000.0
Cycle = tuple[Memory, float, Report]


def cycle(memory: Memory, x: float, demand: float, dp: float = 0.0, gains: Gains = GAINS) -> Cycle:
    memory, voltage, report = step_joint(gains, memory, x, dp, demand, CYCLE)
    return memory, voltage, report


def hold(
    error: float, cycles: int, memory: Memory | None = None, *, dp: float = 0.0, ripple: float = 0.0, speed: float = 0.0
) -> Cycle:
    """Some cycles at a constant error, with a ripple at the dither's frequency, and the joint moving along."""
    memory = memory or wake_joint(GAINS, 0.0, dp)
    result: Cycle = (memory, 0.0, Report(*[0.0] * 8))
    for k in range(cycles):
        swing = (ripple, 0.0, -ripple, 0.0)[k % 4]
        x = speed * CYCLE * k
        result = cycle(result[0], x, x + error, dp + swing)
    return result


def test_at_rest_on_target_the_voltage_is_null() -> None:
    _, voltage, report = hold(0.0, 10)
    assert voltage == GAINS.null
    assert report.phase == 3.0


@given(st.floats(radians(2.0), radians(100.0)))
def test_a_demand_ahead_raises_the_voltage(error: float) -> None:
    assert hold(error, 8)[1] > GAINS.null > hold(-error, 8)[1]


@given(st.floats(1e4, 3e5))
def test_differential_pressure_opposes(dp: float) -> None:
    memory = wake_joint(GAINS, 0.0, dp)
    assert cycle(memory, 0.0, radians(5.0), dp)[1] < cycle(wake_joint(GAINS, 0.0, 0.0), 0.0, radians(5.0))[1]


@pytest.mark.parametrize(
    ("error", "phase", "gains"), [(20.0, 1.0, FAR), (-20.0, 1.0, FAR), (5.0, 2.0, NEAR), (-1.0, 3.0, CLOSE)]
)
def test_phases_by_error(error: float, phase: float, gains: FeedbackGains) -> None:
    dp = 4e4
    memory = wake_joint(GAINS, 0.0, dp)
    after, voltage, report = cycle(memory, 0.0, radians(error), dp)
    assert report.phase == phase
    expected = gains.error_gain * radians(error) - gains.pressure_gain * dp + GAINS.null + after.short_term
    assert voltage == pytest.approx(min(max(expected, 0.0), 10.0), rel=1e-12)


@pytest.mark.parametrize(("speed", "phase"), [(0.0, 3.0), (20.0, 2.0), (-20.0, 2.0), (100.0, 1.0)])
def test_phases_by_speed(speed: float, phase: float) -> None:
    assert hold(radians(0.5) + 1.5 * CYCLE * radians(-speed), 12, speed=radians(speed))[2].phase == phase


def test_speed_is_that_of_the_averaged_angle() -> None:
    report = hold(0.0, 12, speed=1.0)[2]
    assert report.averaged_velocity == pytest.approx(1.0)
    assert report.averaged_angle == pytest.approx((11 - 1.5) * CYCLE)


def test_without_averaging_the_last_sample_counts() -> None:
    memory = wake_joint(GAINS, 0.0, 0.0)
    raw = GAINS._replace(averaged=0.0)
    report = cycle(memory, 0.01, 0.0, 3e4, raw)[2]
    assert (report.averaged_angle, report.averaged_pressure) == (0.01, 3e4)
    assert report.averaged_velocity == pytest.approx(0.01 / CYCLE)


@given(st.floats(-3.0, 3.0), st.floats(-5e5, 5e5))
def test_voltage_stays_within_its_range(error: float, dp: float) -> None:
    assert GAINS.voltage_low <= cycle(wake_joint(GAINS, 0.0, dp), 0.0, error, dp)[1] <= GAINS.voltage_high


def test_short_term_integral_builds_in_phase_3_and_is_clamped() -> None:
    few, many = hold(radians(1.0), 20)[0], hold(radians(1.0), 4000)[0]
    assert few.short_term == pytest.approx(20 * CYCLE * GAINS.integral_gain * radians(1.0))
    assert many.short_term == GAINS.integral_limit


def test_short_term_integral_is_cleared_outside_phase_3() -> None:
    memory = hold(radians(1.0), 100)[0]
    assert memory.short_term > 0.0
    assert cycle(memory, 0.0, radians(5.0))[0].short_term == 0.0


def test_a_held_demand_keeps_its_voltage() -> None:
    memory = hold(radians(1.0), 100)[0]
    voltages = set()
    for _ in range(50):
        memory, voltage, _ = cycle(memory, 0.0, 0.0)
        voltages.add(voltage)
    assert voltages == {GAINS.null + memory.short_term}


def test_long_term_integral_learns_with_air_at_rest_unloaded() -> None:
    memory, _, report = hold(radians(0.05), 400, ripple=RIPPLE)
    assert report.learning == 1.0
    assert memory.long_term > 0.0


def test_a_joint_that_woke_up_is_at_rest_once_the_time_for_it_is_over() -> None:
    least = round(GAINS.rest_time / CYCLE)
    learning = [hold(0.0, cycles, ripple=RIPPLE)[2].learning for cycles in (least - 1, least + 1)]
    assert learning == [0.0, 1.0]


@pytest.mark.parametrize(
    "broken",
    [
        {"ripple": 0.0},
        {"ripple": 0.9 * GAINS.air_ripple},
        {"ripple": RIPPLE, "speed": radians(0.6)},
        {"ripple": RIPPLE, "dp": 1.1 * GAINS.load_pressure},
        {"ripple": RIPPLE, "dp": -1.1 * GAINS.load_pressure},
    ],
    ids=["no air", "little air", "moving", "load forward", "load back"],
)
def test_long_term_integral_obeys_each_of_its_rules(broken: dict[str, float]) -> None:
    # Eight cycles fill the averages.
    early, late = (hold(radians(0.05), cycles, None, **broken) for cycles in (8, 400))
    assert late[2].learning == 0.0
    assert late[0].long_term == early[0].long_term == pytest.approx(0.0, abs=1e-3)


def test_long_term_integral_learns_what_is_held_within_its_time_constant() -> None:
    memory, voltage, report = hold(radians(0.05), 400, ripple=RIPPLE)
    after = cycle(memory, 0.0, radians(0.05))[0]
    held = voltage - GAINS.null - report.long_term
    assert after.long_term - memory.long_term == pytest.approx(held * CYCLE / GAINS.drift_time, rel=0.02)


def test_long_term_integral_is_kept_while_a_rule_is_broken() -> None:
    memory = hold(radians(0.05), 400, ripple=RIPPLE)[0]
    assert hold(radians(5.0), 100, memory)[0].long_term == memory.long_term


def test_handing_over_does_not_disturb_the_sum() -> None:
    memory = hold(0.0, 8, ripple=RIPPLE)[0]._replace(short_term=0.5)
    later = hold(0.0, 4000, memory, ripple=RIPPLE)[0]
    assert later.short_term + later.long_term == pytest.approx(0.5 + memory.long_term, abs=1e-9)
    assert later.long_term > 0.4


def test_long_term_integral_is_clamped() -> None:
    assert hold(radians(0.4), 20000, ripple=RIPPLE)[0].long_term == GAINS.drift_limit


@given(st.floats(-1.0, 1.0), st.floats(-3e5, 3e5))
def test_a_controller_wakes_up_without_a_jolt(x: float, dp: float) -> None:
    _, _, report = cycle(wake_joint(GAINS, x, dp), x, x, dp)
    assert report.averaged_angle == pytest.approx(x, abs=1e-12)
    assert report.averaged_velocity == pytest.approx(0.0, abs=1e-9)
    assert report.ripple == 0.0
