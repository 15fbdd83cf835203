from math import degrees, pi, radians

import numpy as np
import pytest

from layflat.physics.joint import JointParameters
from layflat.sim.loop import Signals, Timing
from tests.physics.plants import (
    CYCLE,
    JOINTS,
    LARGE,
    ONE_LINK,
    PAIR,
    TWO_LINKS,
    VALVE,
    Floats,
    Run,
    joint,
    kinetic_energy,
    run,
    signals,
)

BRAKES = np.array([6.7, 2.2])
PAYLOAD = 1.5


def sines(brakes: bool, cycles: int = 800) -> Signals:
    """Both valves swing: a violent run in open loop."""
    t = np.arange(cycles) * CYCLE
    opening = np.stack([0.08 * np.sin(2 * pi * 0.7 * t), 0.06 * np.sin(2 * pi * 1.1 * t)], axis=1)
    return signals(cycles, 2, opening=opening, brake=BRAKES * brakes, payload=PAYLOAD)


def swing(brakes: bool, steps: int) -> Run:
    return run(TWO_LINKS, JOINTS, sines(brakes), Timing(CYCLE, steps, 1))


def miss(ours: Run, reference: Run) -> float:
    """Greatest rms difference of a joint's angle, in degrees."""
    difference = ours.column("angle") - reference.column("angle")
    return degrees(np.sqrt(np.mean(difference**2, axis=0)).max())


@pytest.mark.compiled
def test_the_default_step_is_fine_enough_with_brakes() -> None:
    reference = swing(True, 2000)
    assert np.degrees(np.ptp(reference.column("angle"), axis=0)).min() > 5.0
    assert miss(swing(True, 20), reference) < 0.01


@pytest.mark.compiled
def test_second_order_without_brakes() -> None:
    reference, steps = swing(False, 2000), np.array([20, 40, 80])
    errors = [miss(swing(False, n), reference) for n in steps]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.8


@pytest.mark.compiled
def test_pulses_meet_no_step_and_cost_no_accuracy() -> None:
    joints = tuple(one._replace(valve=PAIR) for one in JOINTS)

    def swing(steps: int) -> Run:
        return run(TWO_LINKS, joints, sines(True), Timing(CYCLE, steps, 1))

    reference = swing(2000)
    assert np.degrees(np.ptp(reference.column("angle"), axis=0)).min() > 5.0
    assert miss(swing(20), reference) < 0.01


@pytest.mark.compiled
@pytest.mark.parametrize("brakes", [True, False])
@pytest.mark.parametrize("compliance", [0.0, 2e-12])
def test_the_ledger_closes(brakes: bool, compliance: float) -> None:
    joints = (joint(2.05e-4, 1.2e-4, compliance), joint(0.63e-4, 0.5e-4, compliance))
    done = run(TWO_LINKS, joints, sines(brakes))
    book = {name: done.column(name).sum(axis=1) for name in ("gas_work", "load_work", "hose_work")}
    heat = done.column("brake_heat").sum(axis=1) + done.column("damping_heat").sum(axis=1)
    kinetic = kinetic_energy(TWO_LINKS, PAYLOAD, done.column("angle"), done.column("velocity"))
    missing = book["gas_work"] + book["load_work"] - book["hose_work"] - heat - kinetic
    assert np.abs(missing).max() < 1e-3 * np.abs(book["gas_work"]).max()
    assert np.all(np.diff(heat) >= -1e-12)
    assert np.all(book["hose_work"] >= done.column("hose_stored").sum(axis=1) - 1e-9)


@pytest.mark.compiled
def test_an_hour_at_rest_moves_nothing() -> None:
    # The loads are 60 % of what the brakes can hold; the dither goes on all the while.
    hour = run(
        TWO_LINKS,
        JOINTS,
        signals(3600, 2, brake=BRAKES, load=0.6 * BRAKES, payload=PAYLOAD),
        Timing(1.0, 4000, 1),
        angles=(0.2, -0.3),
    )
    assert np.all(hour.column("angle") == [0.2, -0.3])
    assert np.all(hour.column("velocity") == 0.0)


@pytest.mark.compiled
def test_a_load_beyond_the_brake_moves_the_joint() -> None:
    moved = run(ONE_LINK, (LARGE,), signals(100, 1, brake=6.7, load=20.0))
    assert moved.column("angle")[-1, 0] > radians(1.0)


def test_a_valve_that_opens_turns_its_joint_that_way() -> None:
    opening = np.array([0.3, -0.3])
    done = run(TWO_LINKS, JOINTS, signals(6, 2, opening=opening, payload=PAYLOAD))
    first, last = done.column("angle")[0], done.column("angle")[-1]
    assert last[0] > first[0]
    assert last[1] < first[1]


def test_mirrored_machines_move_alike_but_for_the_dither() -> None:
    still = LARGE._replace(valve=VALVE._replace(dither_amplitude=0.0))

    def path(joint: JointParameters, side: float) -> Floats:
        return run(ONE_LINK, (joint,), signals(6, 1, opening=side * 0.2), angles=side * 0.1).column("angle")

    assert np.array_equal(path(still, 1.0), -path(still, -1.0))
    assert not np.array_equal(path(LARGE, 1.0), -path(LARGE, -1.0))


@pytest.mark.parametrize("records", [2, 4])
def test_looking_more_often_changes_no_bit(records: int) -> None:
    coarse = run(TWO_LINKS, JOINTS, sines(True, 8)).records
    fine = run(TWO_LINKS, JOINTS, sines(True, 8), Timing(CYCLE, 20, records)).records
    assert np.array_equal(coarse, fine[::records])


def test_same_run_same_bits() -> None:
    one, two = (run(TWO_LINKS, JOINTS, sines(True, 8)).records for _ in range(2))
    assert np.array_equal(one, two)
