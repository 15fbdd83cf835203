"""Links of arms in space: what of them is looked for, that they stay bodies, and that logs tell what they can."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.arrays import Array
from layflat.description.change import changed, changed_all, value_at
from layflat.identify import fit
from layflat.identify.benches.moving import ArmModel
from layflat.identify.benches.moving.blocks import LINK_WEIGHING, MACHINE_BLOCKS, link_parameters, machine_unknowns
from layflat.identify.benches.moving.bodies import feasible_columns
from layflat.identify.model import Model
from layflat.machine import Machine, load
from layflat.physics.arms.chain.description import describe_inertia_defect
from layflat.sim import rollout

ARM = load("picking-arm")
ELBOW = [f"arm.link.elbow.inertia.{i}" for i in range(3)]


def test_a_link_that_only_turns_about_an_upright_axis_shows_nothing_of_its_height() -> None:
    def of(name: str, path: str) -> set[str]:
        start = f"arm.link.{name}."
        return {spec.path.removeprefix(start) for spec in link_parameters(load(path)) if spec.path.startswith(start)}

    every = {"mass", *(f"{what}.{i}" for what in ("centre", "inertia") for i in range(3)), "rotor_inertia"}
    assert of("base", "picking-arm") == every - {"centre.2", "inertia.0", "inertia.1"}
    assert of("elbow", "picking-arm") == every
    assert of("small", "single-joint-lift") == every - {"centre.1", "inertia.0", "inertia.2"}
    assert link_parameters(load("paper-arm")) == []


def test_every_value_has_a_range_around_the_description() -> None:
    sought = machine_unknowns(ARM, [block for block in MACHINE_BLOCKS if block != "line"])
    assert len({unknown.path for unknown in sought}) == len(sought)
    for unknown in sought:
        assert unknown.low <= unknown.guess <= unknown.high, unknown.path
        assert unknown.low < unknown.high, unknown.path
        assert unknown.guess == value_at(ARM, unknown.path)
        assert unknown.excitation


MOMENTS = st.floats(1e-5, 1e-2)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(MOMENTS, MOMENTS, MOMENTS), min_size=1, max_size=4))
def test_what_no_body_can_have_becomes_the_nearest_that_one_can(given: list[tuple[float, float, float]]) -> None:
    columns = dict(zip(ELBOW, np.array(given).T, strict=True)) | {"valve.delay": np.zeros(len(given))}
    found = feasible_columns(ARM, columns)
    assert list(found) == list(columns)
    for asked, moments in zip(given, np.array([found[path] for path in ELBOW]).T, strict=True):
        assert describe_inertia_defect(tuple(moments)) == ""
        if describe_inertia_defect(asked) == "" and max(asked) < 0.99 * (sum(asked) - max(asked)):
            assert tuple(moments) == asked
    again = feasible_columns(ARM, found)
    assert all(again[path] == pytest.approx(found[path], rel=1e-9) for path in ELBOW)


def test_what_acts_on_no_joint_gives_way_to_what_is_sought() -> None:
    path = "arm.link.small.inertia.1"
    asked = np.array([0.001, 0.029, 0.09])
    found = feasible_columns(load("single-joint-lift"), {path: asked})
    assert np.array_equal(found[path], asked)
    others = [found[f"arm.link.small.inertia.{i}"] for i in (0, 2)]
    for xx, yy, zz in zip(others[0], asked, others[1], strict=True):
        assert describe_inertia_defect((xx, yy, zz)) == ""
    assert (others[0][1], others[1][1]) == (0.0005, 0.029)


TRUTH = {
    "arm.link.small.centre.0": -0.065,
    "arm.link.small.centre.2": 0.012,
    "arm.payload": 0.9,
    "joint.small.brake.torque": 2.5,
}
LIFT = load("single-joint-lift")


def log_of(truth: Machine, described: Machine, levels: Array) -> xarray.Dataset:
    """What the sensors of an arm see whose controller takes it for the described one."""
    duration = 0.5 * len(levels)
    run = rollout(
        truth, lambda t: levels[int(t / 0.5) % len(levels)], duration=duration, start=0.0, seed=1, controller=described
    )
    kept = run[["voltage", "measured_pressure", "dither_share"]].rename(dither_share="dither")
    return kept.assign(angle=run["measured_angle"])


@pytest.mark.compiled
def test_link_payload_and_friction_are_found_from_motion_against_gravity() -> None:
    levels = np.array([[0.0], [0.4], [-0.3], [0.5], [0.0]])
    log = log_of(changed_all(LIFT, TRUTH), LIFT, levels)
    model = ArmModel(LIFT, {"log": log}, blocks=["friction", "inertia", "payload"])
    found = fit(model, starts=0)
    assert found.converged
    sought = [one for one in found.estimates if not one.unknown.nuisance]
    told = [one for one in sought if one.identified]
    truth = {one.unknown.path: TRUTH.get(one.unknown.path, value_at(LIFT, one.unknown.path)) for one in sought}
    assert all(one.low <= truth[one.unknown.path] <= one.high for one in told)
    assert "joint.small.brake.torque" in {one.unknown.path for one in told}
    # A single joint feels mass times distance, and the payload may weigh what the link does.
    for path in ("arm.link.small.mass", "arm.link.small.centre.0", "arm.payload"):
        assert not found.estimate(path).identified
    assert found.estimate("arm.link.small.mass").unknown.excitation == LINK_WEIGHING
    kept = changed_all(LIFT, model.described_values(found.values))
    assert kept.arm.payload == found.estimate("arm.payload").value
    assert max(quality.relative_rms for quality in found.predictions) < 0.01


@pytest.fixture(scope="module")
def picked() -> xarray.Dataset:
    """A log of the picking arm."""
    levels = np.array([[0.0] * 4, [0.3, 0.2, -0.3, 0.4], [-0.2, -0.3, 0.2, -0.3], [0.0] * 4])
    return log_of(ARM, ARM, levels)


def missed(model: Model) -> dict[str, float]:
    """Rms errors of the guess over the sensors' noise, by signal."""
    error, found = model.simulate(model.guess[None])[0] - model.measured, dict[str, list[Array]]()
    for place, output in zip(model.slices, model.outputs, strict=True):
        found.setdefault(output.name.split()[0], []).append(error[place][output.fitted] / output.scale)
    return {name: float(np.sqrt(np.mean(np.square(errors)))) for name, errors in found.items()}


@pytest.mark.compiled
def test_what_an_arm_in_space_did_follows_from_its_voltages_and_dither(picked: xarray.Dataset) -> None:
    assert picked["dither"].min() < 0.5
    with_dither, without = (
        ArmModel(ARM, {"log": log}, blocks=["payload"]) for log in (picked, picked.drop_vars("dither"))
    )
    few, many = (list(missed(model).values()) for model in (with_dither, without))
    assert np.linalg.norm(few) < 0.2 * np.linalg.norm(many)


@pytest.mark.compiled
def test_an_arm_whose_links_are_far_off_is_held_to_its_log(picked: xarray.Dataset) -> None:
    """Gravity takes it away otherwise; right values leave little however it is held."""
    masses = {f"arm.link.{name}.mass": 5.0 * link.mass for name, link in ARM.arm.link.items()}
    heavy = ArmModel(changed_all(ARM, masses), {"log": picked}, blocks=["inertia"])
    _, held, *_ = heavy.continuations()[0]
    assert missed(held)["angle"] < 0.4 * missed(heavy)["angle"]
    right = ArmModel(ARM, {"log": picked}, blocks=["inertia"])
    for model in right.continuations()[0][1:3]:
        assert missed(model)["angle"] < 0.2 * missed(held)["angle"]


@pytest.mark.compiled
def test_in_the_end_links_may_be_what_no_body_can_be(picked: xarray.Dataset) -> None:
    """Making bodies of them is a kink in what they do, at which a search would end."""
    model = ArmModel(ARM, {"log": picked}, blocks=["inertia"])
    held, *_, last = (cast(ArmModel, one) for one in model.continuations()[0])
    values = model.guess.copy()
    values[[unknown.path for unknown in model.unknowns].index(ELBOW[1])] *= 5.0
    assert np.isfinite(last.simulate(values[None])[:, last.used]).all()
    bodies = np.array(list(feasible_columns(ARM, model.columns(values[None])).values()))[:, 0]
    assert np.array_equal(held.simulate(values[None]), held.simulate(bodies[None]), equal_nan=True)
    assert not np.array_equal(last.simulate(values[None]), last.simulate(bodies[None]), equal_nan=True)
    shares, triangle = model.scaling.scale(values), np.eye(len(values))
    for settled in (held, last):
        found = model.scaling.unscale(settled.project(shares, triangle))
        assert np.array(list(feasible_columns(ARM, model.columns(found[None])).values()))[:, 0] == pytest.approx(found)


@pytest.mark.compiled
def test_the_offset_of_a_pressure_sensor_draws_no_air(picked: xarray.Dataset) -> None:
    offset = 3e3
    shifted = picked.assign(measured_pressure=picked["measured_pressure"] + offset)
    known = ArmModel(changed(ARM, "pressure_sensor.offset", offset), {"log": shifted}, blocks=["payload", "sensors"])
    usual = ArmModel(ARM, {"log": picked}, blocks=["payload"])
    first, second = (missed(model.continuations()[0][1])["angle"] for model in (known, usual))
    assert first == pytest.approx(second, rel=0.05)


@pytest.mark.compiled
def test_without_pressures_valves_alone_draw_an_arm_to_its_log(picked: xarray.Dataset) -> None:
    model = ArmModel(ARM, {"log": picked.drop_vars("measured_pressure")}, blocks=["payload"])
    stages = [cast(ArmModel, one).stage for one in model.continuations()[0]]
    assert all(stage.angle > 0.0 and stage.torque == stage.air == 0.0 for stage in stages)
