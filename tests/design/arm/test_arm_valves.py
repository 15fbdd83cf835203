"""Valves of sized arms, against ISO 6358 written out and against hoses that fill in simulation."""

from math import sqrt
from typing import Any

import pytest

from layflat.design.arm import read_task
from layflat.design.arm.components import NOMINAL_FLOWS, _share_of_rate, choose_valve, sold_valves
from layflat.design.arm.sizing import size_arm
from layflat.errors import DesignError
from layflat.machine import load

MACHINE = load("picking-arm")


def test_a_nominal_flow_says_the_conductance() -> None:
    valve, outside = MACHINE.valve, 1.01325e5
    assert valve is not None
    before, behind, b = 6e5 + outside, 5e5 + outside, valve.critical_ratio
    for sold, flow in zip(sold_valves(MACHINE), NOMINAL_FLOWS, strict=True):
        passes = sold.size * valve.conductance * before * sqrt(1.0 - ((behind / before - b) / (1.0 - b)) ** 2)
        assert passes * 60e3 == pytest.approx(flow)


def test_the_smallest_that_does_is_chosen() -> None:
    sold = sold_valves(MACHINE)
    for valve in sold:
        assert choose_valve(sold, valve.size, "") is valve
    assert choose_valve(sold, 1.001 * sold[0].size, "") is sold[1]
    with pytest.raises(DesignError, match=r"arm: joint 'base': needs a valve of 3000 l/min, 1.50 times the largest"):
        choose_valve(sold, 1.5 * sold[-1].size, "arm: joint 'base'")


def test_a_joint_that_gives_much_gains_more_slowly_than_it_loses() -> None:
    gains, middle, loses = (float(_share_of_rate(MACHINE, share)) for share in (0.8, 0.0, -0.8))  # type: ignore[arg-type]
    assert middle == pytest.approx(1.0)
    assert 0.05 < gains < 0.4 < loses


def test_quicker_moves_take_larger_valves() -> None:
    asked: Any = {"reach": "0.6 m", "joints": 1, "payload": "1 kg", "supply": "6 bar"}
    flows = []
    for time in ("2 s", "0.4 s"):
        (part,) = size_arm(read_task(None, **asked, time=time)).parts
        assert part.valve is not None
        flows.append(part.valve.nominal_flow)
    assert flows[0] < flows[1]
