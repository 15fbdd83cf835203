"""Loops that Bouc and Wen's law made: it is recognised, and predicts small ones that elements can't."""

from math import radians
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify import fit
from layflat.identify.benches.hysteresis import curve_errors
from layflat.identify.benches.joint_loops import BENCH, STARTING_LOSSES, LoopModel
from layflat.identify.identification import Identification, LawCandidate
from layflat.identify.identified_file import identified_path
from layflat.machine import changed, load
from layflat.machine.exchanged import with_losses
from tests.identify.benches.bouc_wen import BoucWen, measured

RIG = load("rig-shell-steel")
FITTED, VALIDATION = ((5, 6.0), (20, 8.0), (60, 10.0)), ((2, 4.0), (10, 10.0), (40, 5.0))


def test_loops_of_bouc_and_wen_are_recognised_and_small_ones_predicted(tmp_path: Path) -> None:
    loss = BoucWen(1.5, 0.8, turn=radians(2.0))
    logs, validation = (
        {f"{a} deg": measured(RIG, "small", loss, radians(a), s, seed=a) for a, s in cases}
        for cases in (FITTED, VALIDATION)
    )
    blocks = ("torque", "losses")
    kinds = BENCH.alternatives(RIG, logs, blocks)
    assert list(kinds) == list(STARTING_LOSSES)
    of = [LawCandidate(name, machine, BENCH.model(machine, logs, validation, blocks=blocks), replaces)
          for name, (machine, replaces) in kinds.items()]  # fmt: skip
    path = identified_path("rig-shell-steel", RIG, tmp_path)
    session = Identification("rig-shell-steel", RIG, logs, validation, {}, blocks, of, path)
    found = session.fit(starts=0)
    assert session.fitted_candidate(found).name == "bouc-wen"
    assert "Bouc-wen predicts best" in found.model.remarks[-1]
    assert isinstance(found.model, LoopModel)
    errors = [error.raw for error in curve_errors(found.model, found.simulated) if error.validation]
    assert max(errors) < 0.10
    kept = session.write_results(found).joint["small"].losses  # type: ignore[union-attr]
    assert (kept.kind, kept.beta, kept.exponent) == (
        "bouc-wen",
        pytest.approx(0.75, abs=0.2),
        pytest.approx(1.4, abs=0.2),
    )
    assert load(str(path)).joint["small"].losses == kept


@pytest.mark.parametrize("kind", STARTING_LOSSES)
def test_every_kind_can_be_fitted_to_what_it_shows(kind: str) -> None:
    machine = with_losses(RIG, kind, STARTING_LOSSES[kind](1.0))
    logs = {"log": measured(RIG, "small", BoucWen(1.0, 0.5, turn=radians(1.0)), radians(20), 8.0, seed=1)}
    model = LoopModel(machine, logs, blocks=("torque", "losses"))
    shown = model.simulate(model.guess[None])[0]
    again = LoopModel(machine, {"log": logs["log"].assign(torque=("time", shown))}, blocks=("losses",))
    found = fit(again, starts=0)
    assert np.abs(found.simulated - shown).max() < 1e-6 * np.abs(shown).max()


def test_losses_that_have_no_unknowns_are_refused() -> None:
    creep = {"kind": "creep", "deflection": "2 deg", "per_decade": 0.1, "first": "10 ms", "last": "10 s"}
    pressure = {"reference_pressure_gauge": "3 bar", "pressure_free": 0.25}
    machine = changed(RIG, "joint.small.losses", creep | pressure)
    logs = {"log": measured(RIG, "small", BoucWen(1.0, 0.5, turn=radians(1.0)), radians(20), 8.0, seed=1)}
    assert BENCH.alternatives(machine, logs, ("torque", "losses")) == {}
    with pytest.raises(InputError, match="losses of kind 'creep' can't be fitted to loops; use elasto-slip-spectrum"):
        LoopModel(machine, logs, blocks=("losses",))
