"""Machines identified from logs of motion, the truth known."""

from typing import Any

import numpy as np
import pytest
import xarray
from numpy.typing import NDArray

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.identify import fit
from layflat.identify.benches.moving import ArmModel
from layflat.identify.benches.moving.blocks import MACHINE_BLOCKS, machine_unknowns
from layflat.identify.model import Scaling
from layflat.machine import Machine, changed, load
from layflat.machine.parameters import arm
from layflat.physics.arms.planar import OneLink
from layflat.sim import rollout

SMALL, ARM = load("paper-small-joint-fast"), load("paper-arm-fast")
TRUTH = {
    "valve.conductance": 2.3e-8,
    "valve.overlap": 0.04,
    "valve.centre_voltage": 5.15,
    "valve.delay": 1.5e-3,
    "joint.small.hose.dead_volume": 7e-5,
    "joint.small.brake.torque": 2.6,
}


def as_described(machine: Machine, values: dict[str, float]) -> Machine:
    for path, value in values.items():
        machine = changed(machine, path, value)
    return machine


def demand(t: float) -> list[float]:
    steps = [0.0, 0.3, -0.2, 0.45, -0.4, 0.1]
    return [steps[int(t / 0.75) % 6] + (0.1 * np.sin(6.0 * t * t / 3.0) if 1.5 < t < 4.0 else 0.0)]


def log_of(machine: Machine, duration: float = 6.0, **changes: Any) -> xarray.Dataset:
    """What the sensors of a machine see."""
    run = rollout(machine, demand, duration=duration, start=0.0, **changes)
    return run[["voltage", "measured_pressure"]].assign(angle=run["measured_angle"])


def without_true_angle(log: xarray.Dataset, name: str, values: NDArray[np.float64]) -> xarray.Dataset:
    return log.assign({name: (log[name].dims, values)})


def test_a_valve_a_hose_and_a_brake_are_found() -> None:
    log = log_of(as_described(SMALL, TRUTH), 4.5, seed=3)
    found = fit(ArmModel(SMALL, {"log": log}, blocks=["valve", "hose", "friction"]), starts=0)
    assert found.converged
    for path, value in TRUTH.items():
        estimate = found.estimate(path)
        assert estimate.identified, path
        assert estimate.low <= value <= estimate.high, path
        assert estimate.value == pytest.approx(value, rel=0.03), path
    # Judged by the last third, from the log's start on with nothing but the voltages.
    validation = {quality.output: quality for quality in found.qualities() if quality.validation}
    assert validation["angle"].rms < np.radians(0.2)
    assert validation["measured_pressure"].rms < 500.0


def test_the_truth_leaves_nothing_but_noise() -> None:
    machine = as_described(SMALL, TRUTH)
    log = log_of(machine, seed=1)
    model = ArmModel(machine, {"log": log}, blocks=["valve"])
    begun = [u.path for u in model.unknowns if u.nuisance]
    truth = [0.0 if "angle" in path else 0.75 * machine.supply.pressure for path in begun]
    values = np.array([[*(value_at(machine, u.path) for u in model.unknowns if not u.nuisance), *truth]])
    for place, output in zip(model.slices, model.outputs, strict=True):
        error = model.simulate(values)[0][place] - output.measured
        assert np.sqrt(np.mean(error**2)) < 1.3 * output.scale


GROW = (
    "valve.conductance", "valve.leakage", "joint.small.hose.torque_factor", "joint.small.hose.dead_volume",
    "joint.small.hose.compliance", "joint.small.hose.wall_conductance", "joint.small.brake.torque",
    "joint.small.brake.viscous",
)  # fmt: skip
"""What grows with a joint that is larger throughout."""


def test_the_way_to_a_larger_joint_that_moves_the_same_is_straight() -> None:
    """Only known masses tell how large a joint is: differences along a bent valley would take its sides for that."""
    model = ArmModel(SMALL, {"log": log_of(SMALL, 2.0)}, blocks=["valve", "hose", "friction", "inertia"])
    paths, scaled = [unknown.path for unknown in model.unknowns], Scaling(model.unknowns)
    inertia = paths.index("joint.small.link.inertia")
    masses = arm(SMALL)
    assert isinstance(masses, OneLink)
    known = masses.inertia + SMALL.arm.payload * masses.length**2
    factor = 1.0 + model.guess[inertia] / known
    values = np.tile(model.guess, (3, 1))
    values[1, [paths.index(path) for path in GROW]] *= factor
    values[1, inertia] += (factor - 1.0) * known
    values[2] = scaled.unscale(scaled.scale(values[:2]).mean(axis=0))
    small, large, between = model.simulate(values) / np.repeat(
        [o.scale for o in model.outputs], len(model.measured) // 2
    )
    noise = np.sqrt(small.size)
    assert np.linalg.norm(large - small) < 0.01 * noise
    assert np.linalg.norm(between - small) < 0.01 * noise


def test_a_joint_that_is_led_forgets_where_it_began() -> None:
    log = log_of(SMALL, 3.0)
    model = ArmModel(SMALL, {"log": log}, blocks=["valve"])
    _, far, near = model.continuations()[0]
    off = model.guess.copy()
    off[[u.path for u in model.unknowns].index("valve.centre_voltage")] += 0.1
    last = np.flatnonzero(model.outputs[0].fitted)[-1]

    def error(one: Any) -> float:
        return float(abs(one.simulate(off[None])[0][last] - model.measured[last]))

    assert error(far) < error(near) < error(model)


def test_the_first_rung_sees_the_beginning_alone() -> None:
    model = ArmModel(SMALL, {"log": log_of(SMALL, 3.0)}, blocks=["valve"])
    first, second, _ = model.continuations()[0]
    assert 0 < first.used.sum() < 0.5 * second.used.sum()
    assert np.isfinite(first.simulate(model.guess[None])[0][first.used]).all()
    assert second.used.sum() == model.used.sum()


def test_each_pressure_by_itself_tells_more_than_their_difference() -> None:
    run = rollout(SMALL, demand, duration=4.0, start=0.0)
    pressures = run[["voltage", "pressure_a", "pressure_b"]].assign(angle=run["measured_angle"])
    model = ArmModel(SMALL, {"log": pressures}, blocks=["valve"])
    assert [output.name for output in model.outputs] == ["angle", "pressure_a", "pressure_b"]
    found = fit(model, starts=0)
    assert found.estimate("valve.conductance").value == pytest.approx(1.99e-8, rel=0.01)


def test_another_log_judges_and_all_of_the_first_is_fitted() -> None:
    first, second = log_of(SMALL, 2.0), log_of(SMALL, 1.0, seed=5)
    model = ArmModel(SMALL, {"first": first}, {"second": second}, blocks=["friction"])
    assert [bool(output.fitted.all()) for output in model.outputs] == [True, True, False, False]
    assert not any(output.fitted.any() for output in model.outputs[2:])
    assert {u.path for u in model.unknowns if u.nuisance} == {
        "start.first.angle.small", "start.first.pressure_a.small", "start.first.pressure_b.small"
    }  # fmt: skip


@pytest.mark.parametrize(("bits", "reach"), [(12, np.radians(2.0 * 150.0 / 2**12)), (20, np.radians(4.0 * 0.01))])
def test_a_log_begins_within_counts_and_noise_of_the_first_angle(bits: int, reach: float) -> None:
    machine = changed(SMALL, "angle_sensor.bits", bits)
    model = ArmModel(machine, {"log": log_of(machine, 0.5)}, blocks=["friction"])
    begin = next(one for one in model.unknowns if one.path == "start.log.angle.small")
    assert begin.high - begin.guess == pytest.approx(reach)
    assert begin.guess - begin.low == pytest.approx(reach)


def test_what_is_simulated_ends_where_readings_do() -> None:
    log, narrow = log_of(SMALL, 2.0), changed(SMALL, "angle_sensor.range", 0.4)
    ended = without_true_angle(log, "angle", np.clip(log["angle"].to_numpy(), -0.2, 0.2))
    for given, end in ((ended, 0.2), (log, float(abs(log["angle"]).max()))):
        model = ArmModel(narrow, {"log": given}, blocks=["friction"])
        angle = model.simulate(model.guess[None])[0][model.slices[0]]
        assert np.max(np.abs(angle)) == pytest.approx(end, abs=2e-3)
        assert np.max(np.abs(angle)) <= end


def thrown(duration: float, when: float) -> xarray.Dataset:
    """A log of a joint that is pushed at its stop for 0.15 s."""
    push = np.zeros((round(duration / SMALL.cycle), 1))
    push[round(when / SMALL.cycle) :][: round(0.15 / SMALL.cycle)] = 100.0
    return log_of(SMALL, duration, load=push)


def test_a_log_ends_where_a_joint_is_thrown_to_its_stop() -> None:
    log = thrown(6.0, 4.5)
    model = ArmModel(SMALL, {"log": log}, blocks=["friction"])
    met = float(model.outputs[0].time[-1] + SMALL.cycle)
    assert 4.5 < met < 4.6
    assert model.remarks == (
        f"Log 'log' is used up to {met:.3g} s, where joint 'small' is thrown to its stop: log it again, slower or over "
        "a smaller reach.",
    )
    angle = log["angle"].sel(time=slice(0.0, met)).to_numpy()
    assert angle[-1] > 0.5 * SMALL.joints["small"].stops.mechanical_stroke > angle[-2]
    found = fit(model, starts=0)
    assert found.estimate("joint.small.brake.torque").value == pytest.approx(2.2, rel=0.03)
    assert found.remarks == model.remarks
    with pytest.raises(InputError, match=r"log: is of use only up to 1\.0\d s, where joint 'small' .* log it again"):
        ArmModel(SMALL, {"log": thrown(2.0, 1.0)}, blocks=["friction"])


def test_a_joint_that_comes_to_its_stop_under_control_is_not_thrown() -> None:
    log = log_of(SMALL, 4.0)
    slow = 1.3 * np.sin(2.0 * np.pi * 0.5 * log["time"].to_numpy())[:, None]
    model = ArmModel(SMALL, {"log": without_true_angle(log, "angle", slow)}, blocks=["friction"])
    assert len(model.outputs[0].time) == log.sizes["time"]
    assert not model.remarks


def test_gaps_in_what_was_measured_do_no_harm() -> None:
    log = log_of(SMALL, 3.0)
    angle = log["angle"].to_numpy().copy()
    angle[100:140] = np.nan
    found = fit(ArmModel(SMALL, {"log": without_true_angle(log, "angle", angle)}, blocks=["friction"]), starts=0)
    assert found.estimate("joint.small.brake.torque").value == pytest.approx(2.2, rel=0.03)


def test_a_joint_without_a_pressure_sensor_is_fitted_with_the_others() -> None:
    run = rollout(ARM, lambda t: [*demand(t), 0.0], duration=1.5, start=0.0)
    log = run[["voltage", "measured_pressure"]].assign(angle=run["measured_angle"])
    pressures = log["measured_pressure"].to_numpy().copy()
    pressures[:, 1] = np.nan
    model = ArmModel(ARM, {"log": without_true_angle(log, "measured_pressure", pressures)}, blocks=["friction"])
    assert np.isfinite(model.continuations()[0][1].simulate(model.guess[None])[0][model.used]).all()
    assert model.used.sum() == 3 * np.sum(model.outputs[0].fitted)


def test_every_block_has_a_range_around_the_description_in_every_machine() -> None:
    for name in ("paper-arm-fast", "paper-small-joint-fast", "paper-arm-switching"):
        machine = load(name)
        for unknown in machine_unknowns(machine, [block for block in MACHINE_BLOCKS if block != "line"]):
            assert unknown.low <= unknown.guess <= unknown.high, unknown.path
            assert unknown.low < unknown.high, unknown.path
            assert unknown.guess == value_at(machine, unknown.path)
            assert unknown.excitation


@pytest.mark.parametrize(("blocks", "told"), [(["wings"], "unknown block 'wings'"), ([], "names no block")])
def test_unknown_blocks_are_refused(blocks: list[str], told: str) -> None:
    with pytest.raises(InputError, match=told):
        machine_unknowns(SMALL, blocks)


@pytest.mark.parametrize("missing", ["voltage", "angle"])
def test_a_log_that_lacks_what_is_needed_is_refused(missing: str) -> None:
    with pytest.raises(InputError, match=f"log: has no {missing}"):
        ArmModel(SMALL, {"log": log_of(SMALL, 0.5).drop_vars(missing)}, blocks=["valve"])
