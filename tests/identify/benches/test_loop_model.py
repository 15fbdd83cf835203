from math import radians

import numpy as np
import pytest
import xarray

from layflat.errors import InputError
from layflat.identify import fit
from layflat.identify.benches.hysteresis import curve_errors
from layflat.identify.benches.joint_loops import BENCH as TURNED
from layflat.identify.benches.joint_loops import LoopModel
from layflat.identify.benches.loader import select_bench
from layflat.identify.benches.moving import BENCH as MOVING
from layflat.machine import Machine, changed, load
from tests.identify.benches.bouc_wen import AMBIENT, BoucWen, measured

RIG = load("rig-shell-steel")
BRAKED = load("paper-small-joint")


def truth() -> Machine:
    """The paper's small joint with other losses than described."""
    machine = changed(BRAKED, "joint.small.hose.torque_factor", 0.9)
    for path, value in (
        ("hose.loss_fraction", 1.5 * BRAKED.joint["small"].hose.loss_fraction),
        ("losses.pressure_free", 0.4),
        ("losses.weights", (0.3, 0.5, 0.2)),
        ("losses.deflections", (radians(0.6), radians(3.0), radians(15.0))),
        ("brake.torque", 1.2),
    ):
        machine = changed(machine, f"joint.small.{path}", value)
    return machine


def turned(machine: Machine, gauge: float, seed: int, reach: float = 50.0, noise: float = 0.0) -> xarray.Dataset:
    """A slow sweep that ends in smaller loops, as the model of this machine sees it."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 60.0, 2000)
    angle = np.radians(reach) * np.cos(2 * np.pi * time / 10.0) * np.where(time < 30.0, 1.0, 0.2)
    log = xarray.Dataset(
        {
            "angle": ("time", angle),
            "torque": ("time", np.cos(time)),
            "pressure_a": ("time", np.full(len(time), gauge + AMBIENT)),
        },
        {"time": time},
    )
    model = LoopModel(machine, {"": log}, blocks=("torque",))
    torque = model.simulate(model.guess[None])[0]
    return log.assign(torque=("time", torque + rng.normal(0.0, noise, len(time))))


def test_what_a_machine_shows_is_found_again() -> None:
    real = truth()
    logs = {f"{bar} bar": turned(real, bar * 1e5, seed=bar, noise=0.02) for bar in (1, 3)}
    validation = {"2 bar": turned(real, 2e5, seed=9, reach=35.0)}
    model = LoopModel(BRAKED, logs, validation)
    found = fit(model, starts=16)
    described, joint = model.describe(found.values).joint["small"], real.joint["small"]
    assert described.hose.torque_factor == pytest.approx(0.9, rel=0.01)
    assert described.losses.pressure_free == pytest.approx(0.4, abs=0.1)
    assert described.brake.torque == pytest.approx(1.2, rel=0.15)
    written = model.described_values(found.values)
    assert [written[f"joint.small.losses.weights.{j}"] for j in range(3)] == list(described.losses.weights)
    assert sum(described.losses.weights) == pytest.approx(1.0)
    assert sorted(described.losses.deflections) == pytest.approx(joint.losses.deflections, rel=0.25)
    assert described.hose.loss_fraction == pytest.approx(joint.hose.loss_fraction, rel=0.15)
    assert curve_errors(model, found.simulated)[-1].raw < 0.01


@pytest.mark.parametrize(("n", "beta"), [(1.0, 0.5), (2.0, 1.3)])
def test_loops_of_another_law_are_predicted_at_other_amplitudes_and_speeds(n: float, beta: float) -> None:
    loss = BoucWen(n, beta, turn=radians(1.0))
    logs = {
        f"{a} deg": measured(RIG, "small", loss, radians(a), s, seed=a) for a, s in ((5, 6.0), (20, 8.0), (60, 10.0))
    }
    validation = {
        f"{a} deg": measured(RIG, "small", loss, radians(a), s, seed=a) for a, s in ((2, 4.0), (10, 10.0), (40, 5.0))
    }
    model = LoopModel(RIG, logs, validation)
    found = fit(model, starts=0)
    errors = [error for error in curve_errors(model, found.simulated) if error.validation]
    assert [error.log for error in errors] == list(validation)
    assert max(error.raw for error in errors) < 0.10


def test_several_candidates_are_simulated_as_one_by_one() -> None:
    model = LoopModel(BRAKED, {"log": turned(BRAKED, 2e5, seed=0)}, blocks=("torque", "losses", "brake", "offset"))
    rng = np.random.default_rng(0)
    low, high = (np.array([getattr(u, end) for u in model.unknowns]) for end in ("low", "high"))
    values = low + (high - low) * rng.random((5, len(low)))
    together = model.simulate(values)
    for i in range(len(values)):
        np.testing.assert_allclose(together[i], model.simulate(values[i : i + 1])[0], rtol=1e-12, atol=1e-9)


def test_an_offset_of_the_sensor_moves_the_torque_and_nothing_else() -> None:
    log = turned(truth(), 2e5, seed=0)
    shifted = log.assign(torque=log["torque"] + 5.0)
    plain, moved = (LoopModel(truth(), {"": one}, blocks=("torque", "offset")) for one in (log, shifted))
    values = plain.guess.copy()
    values[1] = 5.0
    np.testing.assert_allclose(moved.simulate(values[None]), plain.simulate(plain.guess[None]) + 5.0, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"joint": "elbow"}, "unknown joint 'elbow'; use"),
        ({"blocks": ("losses", "colour")}, "unknown block 'colour'; choose from torque"),
    ],
)
def test_a_wrong_option_is_named(change: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        LoopModel(BRAKED, {"log": turned(BRAKED, 2e5, seed=0)}, **change)  # type: ignore[arg-type]


def test_a_log_without_torque_is_refused() -> None:
    with pytest.raises(InputError, match="monday: has no torque; map a column"):
        LoopModel(BRAKED, {"monday": turned(BRAKED, 2e5, seed=0).drop_vars("torque")})


def test_a_loop_inside_the_springs_is_beyond_elements_that_slip() -> None:
    """The limit that the documentation states: half the turn at which this loss slips, and a loop that is too high."""
    loss = BoucWen(1.0, 0.5, turn=radians(4.0))
    logs = {f"{a} deg": measured(RIG, "small", loss, radians(a), 8.0, seed=a) for a in (5, 20)}
    model = LoopModel(RIG, logs, {"2 deg": measured(RIG, "small", loss, radians(2), 8.0, seed=2)})
    assert curve_errors(model, fit(model, starts=0).simulated)[-1].raw > 0.10


def test_a_machine_with_torques_and_without_voltages_is_a_loop_bench() -> None:
    log = turned(BRAKED, 2e5, seed=0)
    assert select_bench(BRAKED, {"log": log}) is TURNED
    assert select_bench(BRAKED, {"log": log.assign(voltage=log["torque"])}) is MOVING


@pytest.mark.parametrize("lost", ["absent", "empty"])
def test_logs_without_any_torque_are_refused_in_one_line(lost: str) -> None:
    whole = turned(BRAKED, 1e5, seed=0)
    log = whole.drop_vars("torque") if lost == "absent" else whole.assign(torque=np.nan * whole["torque"])
    for build in (
        lambda: TURNED.model(BRAKED, {"a": log}, {}, blocks=("torque",)),
        lambda: TURNED.alternatives(BRAKED, {"a": log}, ("losses",)),
    ):
        with pytest.raises(InputError, match="logs: hold no torque of any joint; map a column to the signal torque"):
            build()
