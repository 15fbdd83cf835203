"""Sizing: what comes out does what was asked, by its own K, and loads as any machine does."""

from __future__ import annotations

import os
from dataclasses import replace
from math import degrees, radians
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from layflat.control.paper import PaperGainsPart
from layflat.design import HOSE_WIDTHS, SizingRequest, design_joint, size_joint
from layflat.errors import DesignError, InputError, OutputError
from layflat.machine import load
from layflat.machine.parameters import full_travel, torque_constant
from layflat.sim import rollout
from layflat.sim.metrics import measure_moves

SMALL = SizingRequest(25.0, radians(120), 4e5)
LARGE = SizingRequest(82.0, radians(120), 4e5)


@settings(deadline=None, max_examples=15)
@given(torque=st.floats(2, 200), stroke=st.floats(radians(70), radians(160)), supply=st.floats(2e5, 7e5))
def test_a_sized_joint_reaches_torque_and_stroke_without_errors(torque: float, stroke: float, supply: float) -> None:
    try:
        sized = size_joint(SizingRequest(torque, stroke, supply))
    except DesignError:
        assume(False)
    (described,) = sized.machine.joints.values()
    assert torque_constant(described) * supply >= torque * (1 - 1e-5)
    assert full_travel(described) >= stroke
    assert described.hose.width in HOSE_WIDTHS
    assert degrees(described.stops.mechanical_stroke - described.stops.working_stroke) == pytest.approx(20, abs=1e-3)
    assert described.brake.torque == pytest.approx(0.08 * torque_constant(described) * supply, rel=1e-3)
    assert min(stress.safety for stress in sized.design.stresses) >= 1.5 - 1e-3
    assert {f.severity for f in sized.findings} <= {"note"}


def test_sizing_finds_the_papers_joints_again() -> None:
    small, large = size_joint(SMALL).design, size_joint(LARGE).design
    assert small.joint.hose.width == pytest.approx(0.110, rel=0.05)
    assert small.joint.cylinder.diameter == pytest.approx(0.102, rel=0.03)
    assert small.joint.output.radius == pytest.approx(0.0172, rel=0.05)
    assert small.joint.body.mass == pytest.approx(2.0, rel=0.25)
    assert large.joint.hose.width == pytest.approx(0.160)
    assert large.joint.cylinder.diameter == pytest.approx(0.1524, rel=0.02)
    assert large.joint.output.radius == pytest.approx(0.026, rel=0.03)
    assert large.joint.body.mass == pytest.approx(5.5, rel=0.25)


def test_what_is_written_is_what_was_sized(tmp_path: Path) -> None:
    sized = size_joint(SMALL)
    path = sized.write(tmp_path / "new" / "mine.toml")
    machine = load(path)
    assert machine == sized.machine
    assert design_joint(machine).mean_torque == sized.design.mean_torque


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="a run takes minutes without the compiler")
@pytest.mark.parametrize(
    "request_",
    [
        SMALL,
        SizingRequest(100.0, radians(120), 5e5),
        SizingRequest(8.0, radians(90), 2.5e5, payload_inertia=0.1),
        SizingRequest(25.0, radians(120), 4e5, payload_inertia=0.05),
        SizingRequest(25.0, radians(120), 4e5, payload_inertia=0.75, link_length=0.7),
        SizingRequest(60.0, radians(120), 7e5),
    ],
    ids=["small", "large", "low pressure", "light", "heavy", "high pressure"],
)
def test_a_sized_joint_moves_as_well_as_the_papers(request_: SizingRequest) -> None:
    machine = size_joint(request_).machine
    run = rollout(machine, demand=[(0.0, "0 deg"), (0.2, "40 deg")], start="0 deg", duration=2.2)
    ((_, moved),) = measure_moves(run)
    assert moved.settling < 1.5
    assert moved.overshoot < radians(3)


def test_every_written_value_says_where_it_comes_from() -> None:
    sized = size_joint(SMALL)
    for path, source in sized.machine.provenance.items():
        if path.startswith("joint.small.") and source.source == "derived":
            assert source.note, path
    assert sized.machine.provenance["joint.small.hose.width"].source == "derived"
    assert sized.machine.provenance["joint.small.stops.working_stroke"].source == "given"


def test_the_models_joint_scales_to_itself() -> None:
    """Asked for what the paper's small joint gives, the rest stays near the paper's."""
    base = load("paper-small-joint-fast")
    sized = size_joint(SMALL).machine
    old, new = base.joint["small"], sized.joint["small"]
    assert new.hose.dead_volume == pytest.approx(old.hose.dead_volume, rel=0.05)
    assert new.stops.stop_stiffness == pytest.approx(old.stops.stop_stiffness, rel=0.05)
    assert base.valve is not None
    assert sized.valve is not None
    assert sized.valve.conductance == pytest.approx(base.valve.conductance, rel=0.05)


def test_what_is_given_is_kept() -> None:
    sized = size_joint(
        SizingRequest(
            20.0, radians(110), 4e5, hose_width=0.12, cylinder_diameter=0.11, strap_width=0.04, strap_thickness=1e-4,
            payload_inertia=0.5, name="mine",
        )
    )  # fmt: skip
    described = sized.design.joint
    assert sized.machine.name == "mine"
    assert described.hose.width == pytest.approx(0.12)
    assert described.cylinder.diameter == pytest.approx(0.11)
    assert described.strap.width == pytest.approx(0.04)
    assert described.strap.thickness == pytest.approx(1e-4)
    assert sized.machine.arm.payload * described.planar_link.length**2 == pytest.approx(0.5, rel=1e-3)


def gains_of(request: SizingRequest) -> tuple[PaperGainsPart, PaperGainsPart]:
    """Gains of the model, and of what is sized."""
    model, own = load("paper-small-joint-fast").joint["small"].gains, size_joint(request).design.joint.gains
    assert model is not None
    assert own is not None
    return model, own


@pytest.mark.parametrize("supply", [2e5, 4e5, 7e5])
def test_gains_of_the_pressure_act_on_its_share_of_the_supply(supply: float) -> None:
    model, own = gains_of(replace(SMALL, supply=supply))
    for phase in ("far", "near", "close"):
        assert getattr(own, phase).pressure * supply == pytest.approx(getattr(model, phase).pressure * 4e5, rel=1e-3)
        assert getattr(own, phase).error == getattr(model, phase).error
    assert own.integral == model.integral


def test_only_a_joint_that_carries_more_meets_its_phases_at_lower_speeds() -> None:
    model, light = gains_of(replace(SMALL, payload_inertia=0.1))
    assert light.near_below.speed == pytest.approx(model.near_below.speed, rel=1e-3)
    _, heavy = gains_of(replace(SMALL, payload_inertia=4 * 0.365))
    _, heavier = gains_of(replace(SMALL, payload_inertia=16 * 0.365))
    assert heavy.near_below.speed / model.near_below.speed == pytest.approx(0.5, abs=0.02)
    assert heavier.close_below.speed / model.close_below.speed == pytest.approx(0.25, abs=0.01)
    assert heavy.near_below.error == model.near_below.error


@pytest.mark.parametrize("length", [0.2, 0.9])
def test_a_link_of_another_length_is_a_uniform_bar_with_the_same_payload_inertia(length: float) -> None:
    usual, own = (size_joint(request).machine for request in (SMALL, replace(SMALL, link_length=length)))
    link, other = own.joint["small"].planar_link, usual.joint["small"].planar_link
    share = length / other.length
    assert (link.length, link.centre) == pytest.approx((length, length / 2))
    assert link.mass == pytest.approx(share * other.mass, rel=1e-3)
    assert link.inertia == pytest.approx(share**3 * other.inertia, rel=1e-3)
    assert own.arm.payload * length**2 == pytest.approx(0.25, rel=1e-3)
    assert own.joint["small"].hose == usual.joint["small"].hose


def test_a_cylinder_alone_finds_its_hose() -> None:
    described = size_joint(SizingRequest(20.0, radians(110), 4e5, cylinder_diameter=0.11)).design.joint
    assert described.cylinder.diameter == pytest.approx(0.11)
    assert described.hose.width in HOSE_WIDTHS


def test_a_wrap_over_120_deg_is_warned_of() -> None:
    sized = size_joint(SizingRequest(25.0, radians(150), 4e5, wrap=radians(140)))
    warned = [f for f in sized.findings if f.severity == "warning"]
    assert [f.rule for f in warned] == ["wrap"]
    assert all(f.where.startswith("sized-joint.toml: joint.") for f in warned)


def test_texts_with_units_make_the_same_request() -> None:
    assert SizingRequest(torque="25 N m", stroke="120 deg", supply="4 bar", hose_width=None) == SMALL


@pytest.mark.parametrize(
    ("given_as", "says"),
    [
        ({"torque": "25"}, r"size: torque: '25' is a bare number.*25 N m"),
        ({"torque": "25 bar"}, r"size: torque: '25 bar' is not a torque"),
        ({"stroke": "nan deg"}, r"size: stroke: "),
        ({"supply": None}, r"size: supply: is missing"),
        ({"torque": "0 N m"}, r"size: torque: 0 N m is out of range; give 0.5 N m to 1500 N m"),
        ({"torque": "-5 N m"}, r"size: torque: -5 N m"),
        ({"torque": float("nan")}, r"size: torque: "),
        ({"stroke": "1 deg"}, r"size: stroke: 1 deg is out of range; give 30 deg to 200 deg"),
        ({"supply": "40 bar"}, r"size: supply: 40 bar is out of range; give 0.5 bar to 10 bar"),
        ({"wrap": "200 deg"}, r"size: wrap: 200 deg is out of range; give 60 deg to 180 deg"),
        ({"hose_width": "2 m"}, r"size: hose_width: 2000 mm is out of range; give 30 mm to 400 mm"),
        ({"link_length": "5 m"}, r"size: link_length: 5000 mm is out of range; give 20 mm to 3000 mm"),
        ({"stress_margin": 0.5}, r"size: stress_margin: 0.5 is out of range; give 1 to 10"),
    ],
)
def test_bad_requests_are_refused(given_as: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        SizingRequest(**{"torque": "25 N m", "stroke": "120 deg", "supply": "4 bar", **given_as})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("request_", "says"),
    [
        (SizingRequest(1500.0, radians(120), 1e5), "the widest hose sold, 310 mm, can't give 1500 N m over 120 deg"),
        (SizingRequest(100.0, radians(120), 4e5, hose_width=0.08), "a hose of 80 mm can't give 100 N m.*wider hose"),
        (SizingRequest(100.0, radians(120), 4e5, cylinder_diameter=0.08), "a cylinder of 80 mm can't.*larger cylinder"),
        (SizingRequest(25.0, radians(40), 4e5), "40 deg is too short a stroke"),
        (SizingRequest(100.0, radians(120), 4e5, wrap=radians(178)), "size: wrap: with a wrap of 178 deg.*no place of"),
        (SizingRequest(25.0, radians(120), 4e5, strap_width=0.004), "no strap up to 4 mm wide bears"),
        (SizingRequest(25.0, radians(120), 4e5, strap_thickness=0.5e-3), "no strap up to"),
    ],
)
def test_what_no_joint_can_do_is_refused(request_: SizingRequest, says: str) -> None:
    with pytest.raises(DesignError, match=says):
        size_joint(request_)


def test_a_file_in_the_way_is_an_output_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError):
        size_joint(SMALL).write(tmp_path / "file" / "mine.toml")
