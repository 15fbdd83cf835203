from math import nan

import pytest

from layflat.physics.chamber import pressure, temperature
from layflat.physics.hose import swept_volume
from layflat.physics.joint import EnergyLedger, is_sound, joint_at_rest
from tests.physics.plants import AROUND, LARGE, RIGID

SOUND = [True, True, False, False, False]


def test_a_joint_at_rest_has_what_it_was_given() -> None:
    state = joint_at_rest(LARGE, 0.3, 4e5, 3e5, AROUND)
    assert state.motion == (0.3, 0.0, 0.0)
    assert state.valve == (0.0, 0.0)
    assert state.ledger == EnergyLedger(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for hose, p, travel in ((state.hose_a, 4e5, 0.3), (state.hose_b, 3e5, -0.3)):
        volume = RIGID.dead_volume + swept_volume(LARGE.hose_a.stroke, LARGE.hose_a.neutral + travel)
        assert hose.volume == pytest.approx(volume)
        assert pressure(RIGID, hose.energy, hose.volume, AROUND.ambient_pressure) == pytest.approx(p)
        assert (hose.pressure_change, hose.mass_change) == (0.0, 0.0)
        root_temperature = temperature(RIGID, p, hose.mass, hose.volume, AROUND.ambient_pressure)
        assert root_temperature == pytest.approx(AROUND.ambient_temperature)


def test_a_joint_has_diverged_beyond_any_motion_or_without_air() -> None:
    state = joint_at_rest(LARGE, 0.3, 4e5, 3e5, AROUND)
    angles, velocities = (9.9, -9.9, 10.1, -10.1, nan), (9.9e3, -9.9e3, 1.01e4, -1.01e4, nan)
    assert [is_sound(state._replace(motion=state.motion._replace(angle=one))) for one in angles] == SOUND
    assert [is_sound(state._replace(motion=state.motion._replace(velocity=one))) for one in velocities] == SOUND
    assert not is_sound(state._replace(hose_a=state.hose_a._replace(mass=0.0)))
    assert not is_sound(state._replace(hose_b=state.hose_b._replace(mass=-1e-9)))
