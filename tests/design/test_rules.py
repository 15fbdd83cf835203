"""Strap stress and the design rules, one by one."""

from __future__ import annotations

from math import inf, radians
from typing import Any

import pytest

from layflat.design import Finding, design_joint, refuse_errors, strap_stress
from layflat.errors import DesignError
from layflat.machine import Machine, load, names

ARM = load("paper-arm")


def changed(**parts: dict[str, Any]) -> Machine:
    """The paper's arm with other values in its large joint."""
    joint = ARM.joint["large"]
    new = joint.model_copy(update={k: getattr(joint, k).model_copy(update=v) for k, v in parts.items()})
    return ARM.model_copy(update={"joint": {**ARM.joint, "large": new}})


def found(machine: Machine, rule: str) -> list[Finding]:
    return [f for f in design_joint(machine, "large", strict=False).findings if f.rule == rule]


def test_stress_is_tension_and_bending() -> None:
    strap = ARM.joint["large"].strap
    stress = strap_stress(strap, "roller", 0.0075, 4221.0)
    assert stress.tensile == pytest.approx(4221.0 / (0.046 * 0.0001 * 2))
    assert stress.bending == pytest.approx(193e9 * 0.0001 / 0.015)
    assert stress.total == pytest.approx(stress.tensile + stress.bending)
    assert stress.safety == pytest.approx(1.8e9 / stress.total)


def test_a_woven_strap_bends_fibre_by_fibre_and_a_solid_one_as_a_whole() -> None:
    webbing = load("rig-polyester").joint["small"].strap
    assert strap_stress(webbing, "roller", 0.0075, 1000.0).bending == pytest.approx(3e9 * 25e-6 / 0.015)
    solid = webbing.model_copy(update={"fibre": 0.0})
    assert strap_stress(solid, "roller", 0.0075, 1000.0).bending == pytest.approx(3e9 * 2e-3 / 0.015)


def test_bending_over_an_edge_is_infinite_and_no_load_is_safe() -> None:
    strap = ARM.joint["large"].strap
    assert strap_stress(strap, "edge", 0.0, 1.0).safety == 0.0
    assert strap_stress(strap, "flat", inf, 0.0).safety == inf


def test_the_papers_strip_bears_its_rollers_but_only_just() -> None:
    # Section 2.1.2: no permanent bending over the 15 mm rollers.
    stress = {s.location: s for s in design_joint("rig-shell-steel").stresses}["deflecting roller"]
    assert 1.0 < stress.safety < 1.2


@pytest.mark.parametrize("name", names())
def test_built_in_joints_have_no_errors(name: str) -> None:
    for joint in load(name).joints:
        assert all(f.severity != "error" for f in design_joint(name, joint).findings)


def test_wrap_over_120_deg_is_a_warning() -> None:
    assert not found(ARM, "wrap")
    (finding,) = found(changed(hose={"wrap": radians(130)}), "wrap")
    assert finding.severity == "warning"
    assert str(finding) == (
        "paper-arm: joint.large.hose.wrap: 130 deg; over 120 deg the hose kinks and slides: loss and wear"
    )


def test_wrap_over_180_deg_is_refused() -> None:
    with pytest.raises(DesignError, match="at most 180 deg"):
        design_joint(changed(hose={"wrap": radians(200)}), "large")


def test_a_strap_over_yield_is_refused_unless_only_listed() -> None:
    weak = changed(strap={"yield_stress": 0.5e9})
    with pytest.raises(
        DesignError, match=r"joint\.large\.strap: .* MPa over the cam .* yield 500 MPa; a thinner strap"
    ):
        design_joint(weak, "large")
    (finding,) = found(weak, "strap stress")
    assert finding.severity == "error"


def test_a_strap_near_yield_is_a_warning() -> None:
    (finding,) = found(changed(strap={"yield_stress": 1.1e9}), "strap stress")
    assert finding.severity == "warning"


def test_a_strap_wider_than_the_hose_is_refused() -> None:
    with pytest.raises(DesignError, match=r"strap\.width: 200 mm is wider than the hose; at most 160 mm"):
        design_joint(changed(strap={"width": 0.2}), "large")


def test_a_strap_that_dips_below_the_edge_is_a_note_and_a_further_shaft_cures_it() -> None:
    (finding,) = found(changed(output={"shaft_offset": 0.030}), "slot")
    assert finding.severity == "note"
    assert not found(ARM, "slot")


def test_a_badly_placed_shaft_is_a_warning() -> None:
    (finding,) = found(changed(output={"shaft_offset": 0.001}), "alignment")
    assert finding.severity == "warning"


def test_a_central_shaft_without_rollers_is_a_warning() -> None:
    (finding,) = found(changed(output={"shaft_offset": 0.0}), "deflection")
    assert (finding.severity, finding.where) == ("warning", "paper-arm: joint.large.output.shaft_offset")


def test_a_working_stroke_beyond_the_hose_is_refused() -> None:
    with pytest.raises(DesignError, match=r"140 deg, but the hose turns the output by 133\.3 deg only"):
        design_joint(changed(stops={"working_stroke": radians(140)}), "large")


def test_a_cam_too_large_for_its_stroke_is_refused_in_one_line() -> None:
    with pytest.raises(DesignError, match=r"paper-arm: joint\.large\.output") as caught:
        design_joint(changed(output={"radius": 0.074}), "large")
    assert "\n" not in str(caught.value)


def test_a_round_roller_is_noted() -> None:
    (finding,) = found(changed(output={"kind": "roller"}), "constant torque")
    assert "falls to 51 %" in finding.what or "falls to 50" in finding.what


def test_worst_findings_come_first_and_only_errors_are_raised() -> None:
    bad = changed(strap={"yield_stress": 0.5e9}, hose={"wrap": radians(130)})
    findings = design_joint(bad, "large", strict=False).findings
    severities = [f.severity for f in findings]
    assert severities == sorted(severities, key=["error", "warning", "note"].index)
    refuse_errors([f for f in findings if f.severity != "error"])
    with pytest.raises(DesignError):
        refuse_errors(findings)
