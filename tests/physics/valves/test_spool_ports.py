import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.valves import VALVE_KINDS, at_rest, move, net_opening, start_wave, weaken_wave
from layflat.physics.valves.spool_laws import (
    DitherFraction,
    MeanSpool,
    SpoolState,
    average_over_dither,
    path_conductance,
)
from tests.physics.plants import VALVE

MEAN: MeanSpool = average_over_dither(VALVE)
PERIOD = np.linspace(0.0, 2.0 * np.pi, 2001)[:-1]


def settled(opening: float, share: float) -> tuple[float, float]:
    """Conductances of both paths once the spool is at an opening."""
    _, fills, vents = move(MEAN, SpoolState(opening, 0.0), opening, DitherFraction(share), 1e-3)
    return fills, vents


@pytest.mark.parametrize("opening", [0.0, 0.02, -0.05, 0.15, 0.6])
def test_it_lets_through_what_a_dithered_spool_does_on_average(opening: float) -> None:
    swung = opening + VALVE.dither_amplitude * np.sin(PERIOD)
    for way, found in zip((1.0, -1.0), settled(opening, 1.0), strict=True):
        mean = np.mean([path_conductance(VALVE, way * x) for x in swung])
        assert found == pytest.approx(mean, abs=0.012 * VALVE.conductance)


@given(st.floats(-1.0, 1.0))
def test_without_dither_it_is_the_spool(opening: float) -> None:
    expected = path_conductance(VALVE, opening), path_conductance(VALVE, -opening)
    assert settled(opening, 0.0) == pytest.approx(expected)


def test_it_is_a_valve_of_the_table() -> None:
    state = at_rest(MEAN)
    wave = start_wave(MEAN, 0.3, 1e-3)
    assert wave == DitherFraction(1.0)
    assert weaken_wave(MEAN, wave, 0.3) == DitherFraction(0.3)
    for _ in range(40):
        state, _, _ = move(MEAN, state, 0.4, wave, 1e-3)
    assert net_opening(MEAN, state) == pytest.approx(0.4, abs=1e-3)
    assert VALVE_KINDS.kind_of(VALVE).mean is not None
