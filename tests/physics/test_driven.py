from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.jit import kernel
from layflat.lanes import leaves
from layflat.machine import load, parameters
from layflat.physics.chamber import Chamber, air_mass, energy, temperature
from layflat.physics.chamber import pressure as pressure_of
from layflat.physics.driven import kink_valve, leak_through_hole
from layflat.physics.joint import HoseParameters, HoseState, hose_at_rest
from layflat.physics.valves import held_at, move, net_opening, seized, start_wave

HOSE: HoseParameters = parameters.joints(load("paper-small-joint"))[0].hose_a
P_A = 101325.0


@given(st.floats(1.1e5, 9e5), st.floats(250.0, 350.0), st.floats(0.0, 1.0))
def test_a_hole_lets_out_air_as_warm_as_it_is(p: float, T: float, share: float) -> None:
    before: HoseState = hose_at_rest(HOSE, 0.5, p, T, P_A)
    after: HoseState = leak_through_hole(HOSE, before, share, P_A)
    chamber: Chamber = HOSE.chamber
    assert after.pressure - P_A == pytest.approx((1.0 - share) * (p - P_A), abs=1e-3)
    assert pressure_of(chamber, after.energy, after.volume, P_A) == pytest.approx(after.pressure)
    assert temperature(chamber, after.pressure, after.mass, after.volume, P_A) == pytest.approx(T)
    assert after.mass <= before.mass * (1.0 + 1e-12)
    assert (after.volume, after.loss) == (before.volume, before.loss)


def test_a_hole_without_a_share_changes_next_to_nothing() -> None:
    p, T = 3e5, 293.0
    before: HoseState = hose_at_rest(HOSE, 0.5, p, T, P_A)
    after: HoseState = leak_through_hole(HOSE, before, 0.0, P_A)
    assert list(leaves(after)) == pytest.approx(list(leaves(before)))
    assert before.mass == air_mass(HOSE.chamber, p, T, before.volume, P_A)
    assert before.energy == energy(HOSE.chamber, p, before.volume, P_A)


@kernel
def opening_after(valve: Any, state: Any, command: float, steps: int) -> Any:
    h = 0.25e-3
    for i in range(steps):
        state, fills, vents = move(valve, state, command, start_wave(valve, i * h, h), h)
    return net_opening(valve, state), fills, vents


@pytest.mark.parametrize("name", ["paper-small-joint", "paper-small-joint-switching"])
@pytest.mark.parametrize("opening", [-1.0, -0.3, 0.0, 0.6])
@pytest.mark.parametrize("command", [-1.0, 1.0])
def test_a_seized_valve_of_any_kind_does_not_move(name: str, opening: float, command: float) -> None:
    valve = parameters.joints(load(name))[0].valve
    held = held_at(valve, opening)
    assert opening_after(seized(valve), held, command, 400)[0] == pytest.approx(opening, abs=1e-12)
    assert opening_after(valve, held, command, 400)[0] * command > 0.7


@pytest.mark.parametrize("name", ["paper-small-joint", "paper-small-joint-switching"])
def test_a_kink_leaves_the_valve_its_motion(name: str) -> None:
    valve = parameters.joints(load(name))[0].valve
    state = held_at(valve, 0.0)
    free, narrow = (opening_after(each, state, 1.0, 40) for each in (valve, kink_valve(valve, 0.25)))
    assert narrow[0] == free[0]
    assert narrow[1:] == pytest.approx((0.25 * free[1], 0.25 * free[2]))
