"""Friction in the whole plant."""

from math import degrees

import numpy as np
import pytest

from layflat.physics.friction.stribeck import KIND, Stribeck
from layflat.sim.loop import Timing
from tests.physics.plants import CYCLE, JOINTS, PASSIVE, TWO_LINKS, Floats, Run, kinetic_energy, run, signals

BRAKES, PAYLOAD = np.array([6.7, 2.2]), 1.5
FALLING = Stribeck(0.3, 1.0 / 0.1**2, 0.2, 0.02)
RUBBING = tuple(joint._replace(friction=FALLING) for joint in JOINTS)
pytestmark = pytest.mark.compiled


def swung(steps: int = 20, friction: Stribeck = FALLING) -> Run:
    t = np.arange(400) * CYCLE
    opening = np.stack([0.08 * np.sin(4.4 * t), 0.06 * np.sin(6.9 * t)], axis=1)
    acting = signals(len(t), 2, opening=opening, brake=BRAKES, payload=PAYLOAD)
    joints = tuple(joint._replace(friction=friction) for joint in JOINTS)
    return run(TWO_LINKS, joints, acting, Timing(CYCLE, steps, 1))


def miss(ours: Run, reference: Run) -> float:
    difference = ours.column("angle") - reference.column("angle")
    return degrees(np.sqrt(np.mean(difference**2, axis=0)).max())


def test_the_ledger_closes_and_friction_only_takes() -> None:
    done = swung()
    book = {name: done.column(name).sum(axis=1) for name in ("gas_work", "load_work", "hose_work")}
    heat = done.column("brake_heat").sum(axis=1) + done.column("damping_heat").sum(axis=1)
    kinetic = kinetic_energy(TWO_LINKS, PAYLOAD, done.column("angle"), done.column("velocity"))
    missing = book["gas_work"] + book["load_work"] - book["hose_work"] - heat - kinetic
    assert np.abs(missing).max() < 1e-3 * np.abs(book["gas_work"]).max()
    assert np.all(np.diff(done.column("brake_heat"), axis=0) >= -1e-12)
    assert np.degrees(np.ptp(done.column("angle"), axis=0)).min() > 3.0


def test_the_default_step_is_fine_enough() -> None:
    assert miss(swung(), swung(400)) < 0.02


def test_plain_parameters_are_coulomb_friction_bit_for_bit() -> None:
    t = np.arange(100) * CYCLE
    acting = signals(len(t), 2, opening=0.1 * np.sin(9.0 * t)[:, None], brake=BRAKES, payload=PAYLOAD)
    plain = tuple(joint._replace(friction=KIND.plain) for joint in JOINTS)
    assert np.array_equal(run(TWO_LINKS, plain, acting).records, run(TWO_LINKS, JOINTS, acting).records)


def test_an_hour_at_rest_between_kinetic_and_static_friction_moves_nothing() -> None:
    passive = tuple(PASSIVE._replace(friction=FALLING) for _ in range(2))
    acting = signals(3600, 2, brake=BRAKES, load=1.2 * BRAKES, payload=PAYLOAD)
    hour = run(TWO_LINKS, passive, acting, Timing(1.0, 4000, 1), angles=(0.2, -0.3))
    assert np.all(hour.column("angle") == [0.2, -0.3])
    assert np.all(hour.column("velocity") == 0.0)


def slid(steps: int) -> Floats:
    """Angles of both joints, torn loose and drawn away by a load, in an arm without hoses."""
    smooth = Stribeck(0.5, 1.0, 0.0, 0.0)
    joints = tuple(PASSIVE._replace(friction=smooth) for _ in range(2))
    acting = signals(40, 2, brake=BRAKES, load=[22.0, 8.5], payload=PAYLOAD)
    done = run(TWO_LINKS, joints, acting, Timing(CYCLE, steps, 1))
    assert np.all(done.column("velocity")[2:] > 0.0), "neither turns back"
    return done.column("angle")


def test_sliding_is_of_second_order() -> None:
    reference, steps = slid(400), np.array([5, 10, 20])
    errors = [np.abs(slid(n) - reference).max() for n in steps]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.8
