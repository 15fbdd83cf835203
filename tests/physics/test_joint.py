import pytest
from plants import AROUND, LARGE, RIGID

from layflat.physics.chamber import pressure, temperature
from layflat.physics.hose import swept_volume
from layflat.physics.joint import Ledger, joint_at_rest


def test_a_joint_at_rest_has_what_it_was_given() -> None:
    state = joint_at_rest(LARGE, 0.3, 4e5, 3e5, AROUND)
    assert state.motion == (0.3, 0.0, 0.0)
    assert state.valve == (0.0, 0.0)
    assert state.ledger == Ledger(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for hose, p, travel in ((state.hose_a, 4e5, 0.3), (state.hose_b, 3e5, -0.3)):
        volume = RIGID.dead_volume + swept_volume(LARGE.hose_a.stroke, LARGE.hose_a.neutral + travel)
        assert hose.volume == pytest.approx(volume)
        assert pressure(RIGID, hose.energy, hose.volume, AROUND.ambient_pressure) == pytest.approx(p)
        root_temperature = temperature(RIGID, p, hose.mass, hose.volume, AROUND.ambient_pressure)
        assert root_temperature == pytest.approx(AROUND.ambient_temperature)
