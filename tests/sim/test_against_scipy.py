"""The whole plant against SciPy's LSODA, which is given the same laws as an ordinary differential equation."""

import numpy as np
import pytest

from benchmarks.scipy_plant import OPENINGS, STATES, run
from layflat.machine import load, parameters
from layflat.physics.chamber import pressure
from layflat.physics.hose import swept_volume
from layflat.sim import rollout

SECONDS = 0.05


@pytest.mark.compiled
def test_the_air_goes_where_lsoda_has_it() -> None:
    machine = load("paper-arm")
    around = parameters.surroundings(machine)
    filled = 0.75 * around.supply_pressure
    ours = rollout(
        machine, opening=dict(zip(machine.joints, OPENINGS, strict=True)), start=0.0, pressures=(filled, filled),
        noise=False, duration=SECONDS,
    ).isel(time=-1)  # fmt: skip
    theirs = run(machine, SECONDS).reshape(len(machine.joints), STATES)
    assert np.degrees(np.abs(theirs[:, 0] - ours["angle"].to_numpy()).max()) < 0.05
    for j, joint in enumerate(parameters.joints(machine)):
        for k, (hose, way) in enumerate(((joint.hose_a, 1.0), (joint.hose_b, -1.0))):
            energy, volume = theirs[j, 4 + 5 * k], swept_volume(hose.stroke, hose.neutral + way * theirs[j, 0])
            found = pressure(hose.chamber, energy, hose.chamber.dead_volume + volume, around.ambient_pressure)
            own = float(ours[f"pressure_{'ab'[k]}"][j])
            assert abs(own - filled) > 500.0
            assert found - filled == pytest.approx(own - filled, rel=0.02)
