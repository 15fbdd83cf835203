import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from layflat.physics.hysteresis.elasto_slip import ElastoSlip, ElementTorques, slip_all, slip_element, stored_energy
from tests.physics.plants import losses

Floats = NDArray[np.float64]
LOSS = losses(10.0)
P_G = 4e5
TRAVEL = 20.0
"""Radians after which every element slips, whatever it remembers."""


def walk(path: Floats, loss: ElastoSlip = LOSS, p_g: float = P_G) -> Floats:
    """Torque at every point of a path that starts at an untouched hose."""
    f, torques = ElementTorques((0.0, 0.0, 0.0)), [0.0]
    for turn in np.diff(path):
        f = slip_all(loss, f, turn, p_g, 1.0)
        torques.append(sum(f.torque))
    return np.array(torques)


def loop(amplitude: float, points: int = 400) -> Floats:
    """Three cycles of equal amplitude; the first one leaves the untouched state."""
    return amplitude * np.sin(np.linspace(0.0, 6 * np.pi, 3 * points + 1))


def lost(path: Floats, torque: Floats) -> float:
    """Work lost in the last of three cycles."""
    third = len(path) // 3
    return float(np.trapezoid(torque[-third - 1 :], path[-third - 1 :]))


@given(st.lists(st.floats(-0.3, 0.3), min_size=1, max_size=30), st.floats(0.0, 6e5))
def test_dissipation_is_never_negative(turns: list[float], p_g: float) -> None:
    f = ElementTorques((0.0, 0.0, 0.0))
    for turn in turns:
        before, f = f, slip_all(LOSS, f, turn, p_g, 1.0)
        work = sum(f.torque) * turn
        assert work - (stored_energy(LOSS, f) - stored_energy(LOSS, before)) >= -1e-12


def test_a_full_slip_carries_the_slip_torque() -> None:
    assert walk(np.array([0.0, TRAVEL]))[-1] == pytest.approx(10.0)
    assert walk(np.array([0.0, TRAVEL]), p_g=0.0)[-1] == pytest.approx(2.5)
    assert walk(np.array([0.0, TRAVEL]), p_g=-1e5)[-1] == pytest.approx(2.5)


@given(st.floats(0.01, 0.2), st.floats(0.0, 0.9))
def test_a_closed_inner_loop_returns_to_where_it_left(amplitude: float, share: float) -> None:
    turn, back = amplitude, amplitude * (1.0 - share)
    torque = walk(np.array([0.0, turn, back, turn, 2 * turn]))
    plain = walk(np.array([0.0, turn, 2 * turn]))
    assert torque[3] == pytest.approx(torque[1], abs=1e-12)
    assert torque[4] == pytest.approx(plain[2], abs=1e-12)


@given(st.floats(0.01, 0.3))
def test_a_repeated_cycle_repeats_its_torque(amplitude: float) -> None:
    torque = walk(loop(amplitude, 100))
    assert torque[101:201] == pytest.approx(torque[201:301], abs=1e-9)


def test_speed_does_not_matter() -> None:
    coarse = walk(np.array([0.0, 0.1, -0.05, 0.3, 0.2]))
    fine = walk(np.interp(np.arange(0.0, 4.01, 0.01), range(5), [0.0, 0.1, -0.05, 0.3, 0.2]))
    assert fine[::100] == pytest.approx(coarse, abs=1e-9)


def test_small_loops_lose_less_than_their_share() -> None:
    amplitudes = np.array([0.05, 0.1, 0.2, 0.5])
    per_turn = np.array([lost(loop(a), walk(loop(a))) / a for a in amplitudes])
    assert np.all(np.diff(per_turn) > 0.0)
    # Below the first slip nothing is lost at all.
    assert lost(loop(0.001), walk(loop(0.001))) == pytest.approx(0.0, abs=1e-12)


def test_loss_as_a_share_of_torque_falls_with_pressure() -> None:
    heights = [walk(np.array([0.0, TRAVEL]), p_g=p)[-1] / p for p in (1e5, 2e5, 4e5)]
    assert heights[0] > heights[1] > heights[2]


@given(st.floats(-5.0, 5.0), st.floats(1.0, 100.0), st.floats(0.0, 5.0), st.floats(-1.0, 1.0))
def test_an_element_never_carries_more_than_its_slip_torque(f: float, k: float, Y: float, turn: float) -> None:
    assert abs(slip_element(f, k, Y, turn)) <= Y


def test_an_absent_element_stores_nothing() -> None:
    assert stored_energy(ElastoSlip(*[(0.0, 0.0, 0.0)] * 3), ElementTorques((0.0, 0.0, 0.0))) == 0.0
