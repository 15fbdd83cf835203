from typing import Any

import numpy as np
import pytest

from layflat.jit import composition, kernel
from layflat.lanes import halves, join
from layflat.physics.chamber import pressure
from layflat.physics.driver import DitherPhasor
from layflat.physics.joint import joint_at_rest
from layflat.physics.step import advance_to_midpoint, finish_step, pack_hoses, unpack_hoses
from layflat.physics.valves import start_wave, turn_wave
from tests.physics.plants import AROUND, LARGE, PAIR, SMALL, VALVE

H = 2.5e-4
STILL = DitherPhasor(0.0, 1.0, 0.0, 1.0)


@composition
def advanced(joint: Any, state: Any, opening: Any, v: Any, around: Any) -> Any:
    """A few steps with the velocities prescribed."""
    running, wave = pack_hoses(state), start_wave(joint.valve, 0.0, H)
    for _ in range(20):
        mid = advance_to_midpoint(joint, running, opening, wave, around, H)
        running = finish_step(joint, running, mid, v, 0.0 * v, 0.0 * v, H)
        wave = turn_wave(joint.valve, wave)
    return unpack_hoses(running)


@kernel
def side_by_side(joint_1: Any, joint_2: Any, state_1: Any, state_2: Any, around: Any) -> Any:
    both = advanced(
        join(joint_1, joint_2), join(state_1, state_2), join(0.4, -0.3), join(2.0, -1.0), join(around, around)
    )
    return halves(both)


@kernel
def alone(joint: Any, state: Any, opening: float, v: float, around: Any) -> Any:
    return advanced(joint, state, opening, v, around)


@pytest.mark.compiled
@pytest.mark.parametrize("valve", [VALVE, PAIR], ids=["spool", "switching"])
def test_joints_side_by_side_are_bit_for_bit_joints_alone(valve: Any) -> None:
    large, small = LARGE._replace(valve=valve), SMALL._replace(valve=valve)
    state_1, state_2 = joint_at_rest(large, 0.3, 4e5, 3e5, AROUND), joint_at_rest(small, -0.2, 2e5, 3.5e5, AROUND)
    first, second = side_by_side(large, small, state_1, state_2, AROUND)
    assert first == alone(large, state_1, 0.4, 2.0, AROUND)
    assert second == alone(small, state_2, -0.3, -1.0, AROUND)
    assert first.valve != state_1.valve


@composition
def stepped(joint: Any, state: Any, v: float, impulse: float, load: float, opening: float, around: Any) -> Any:
    """One step with the velocity prescribed: the state after it, and the torques in its middle."""
    running = pack_hoses(state)
    mid = advance_to_midpoint(joint, running, opening, STILL, around, H)
    return unpack_hoses(finish_step(joint, running, mid, v, impulse, load, H)), mid.torque, mid.gas_torque


def test_a_step_drifts_and_books_what_it_did() -> None:
    state = joint_at_rest(LARGE, 0.1, 4e5, 3e5, AROUND)
    after, torque, gas_torque = stepped(LARGE, state, 0.02, -0.5, 1.5, 0.0, AROUND)
    assert torque == gas_torque == pytest.approx(2.05e-4 * 1e5, rel=1e-3)
    assert after.motion.angle == pytest.approx(0.1 + 0.5 * H * 0.02)
    turn = H * 0.01
    assert after.ledger.gas_work == pytest.approx(gas_torque * turn)
    assert after.ledger.load_work == pytest.approx(1.5 * turn)
    assert after.ledger.brake_heat == pytest.approx(0.5 * 0.01)


@composition
def joined_and_parted(state: Any) -> Any:
    return unpack_hoses(pack_hoses(state))


def test_parting_undoes_joining() -> None:
    state = joint_at_rest(LARGE, 0.1, 4e5, 3e5, AROUND)
    assert joined_and_parted(state) == state


def test_pressure_stays_that_of_the_air_that_is_there() -> None:
    after = joint_at_rest(LARGE, 0.0, 3e5, 3e5, AROUND)
    for _ in range(40):
        after, _, _ = stepped(LARGE, after, 1.0, 0.0, 0.0, 0.8, AROUND)
    assert after.hose_a.mass > 1.03 * after.hose_b.mass
    for hose, own in ((LARGE.hose_a, after.hose_a), (LARGE.hose_b, after.hose_b)):
        told = pressure(hose.chamber, own.energy, own.volume, AROUND.ambient_pressure)
        assert own.pressure == pytest.approx(told, rel=3e-4)


def test_moving_the_joint_moves_air_as_its_volume_says() -> None:
    state = joint_at_rest(LARGE, 0.0, 3e5, 3e5, AROUND)
    # Ports covered and no leak to speak of: what hose A gains in volume it loses in pressure.
    shut = LARGE._replace(valve=VALVE._replace(leakage=0.0, dither_amplitude=0.0))
    after = state
    for _ in range(40):
        after, _, _ = stepped(shut, after, 1.0, 0.0, 0.0, 0.0, AROUND)
    assert after.motion.angle == pytest.approx(39.5 * H)
    assert after.hose_a.mass == state.hose_a.mass
    assert after.hose_a.pressure < 3e5 < after.hose_b.pressure
    swept = after.hose_a.volume - state.hose_a.volume
    assert swept == pytest.approx(2.05e-4 * after.motion.angle, rel=1e-9)
    assert np.isclose(after.hose_b.volume - state.hose_b.volume, -swept)
