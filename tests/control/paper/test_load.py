"""Eq. (2) under gravity and against springs: what holds the arm is taken off what is fed back."""

import pytest

from layflat.control.paper.law import DescribedLoad, NoLoad, feedback_pressure
from layflat.description.change import changed
from layflat.machine import load
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.machine.parameters import arm, mass_and_pull, plant, torque_constant


def test_nothing_is_taken_off_where_nothing_is_known() -> None:
    assert feedback_pressure(NoLoad(), (0.1, -0.2), (3e4, -1e4)) == (3e4, -1e4)


def test_an_arm_that_is_held_feeds_nothing_back() -> None:
    machine, q = changed(load("paper-arm"), "arm.gravity", 9.81), (0.3, -0.4)
    _, pull = mass_and_pull(arm(machine), machine.arm.payload, q)
    held = tuple(-of / (2.0 * torque_constant(j)) * 2.0 for of, j in zip(pull, machine.joints.values(), strict=True))
    assert feedback_pressure(DescribedLoad(*plant(machine)), q, held) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_level_arm_needs_nothing() -> None:
    assert feedback_pressure(DescribedLoad(*plant(load("paper-arm"))), (0.3, -0.4), (3e4, -1e4)) == (3e4, -1e4)


def test_a_file_asks_for_it() -> None:
    plain, sources = tables("paper-arm")
    told = {**plain, "controller": {**plain["controller"], "load_compensation": True}}
    from layflat.machine import parameters

    assert isinstance(parameters.control(build(told, sources, "told")).load, DescribedLoad)
    assert isinstance(parameters.control(load("paper-arm")).load, NoLoad)
