"""The paper's claims: they agree, and they can fail."""

from dataclasses import replace

import pytest

from layflat.experiments import Bench, Reproduction, bench, reproduce
from layflat.experiments.reproduction import ORDER
from layflat.machine import changed, load

STATICS = {
    "table-1", "mean-torque", "large-joint-torque", "small-joint-torque", "torque-per-mass", "constant-torque",
}  # fmt: skip
SETTLING = {"unbraked-joint", "braked-joint", "two-axis-settling", "repeatability", "coupling"}
BRAKE = {"open-loop-hysteresis", "loop-character", "overall-hysteresis", "dither-motion"}
DITHER = {"dither-motion", "dither-need", "long-term-integral"}
LOSSES = {"open-loop-hysteresis", "overall-hysteresis", "loop-character"}


def failed(on: Bench) -> set[str]:
    return {claim.id for claim in reproduce(on).claims if not claim.agrees}


def test_all_twenty_claims_agree(paper: Reproduction) -> None:
    assert [claim.id for claim in paper.claims] == list(ORDER)
    assert len(ORDER) == 20
    assert [claim.id for claim in paper.claims if not claim.agrees] == []


def test_without_brake_only_what_needs_it_fails() -> None:
    broken = failed(replace(bench(), brake=0.0))
    assert {
        "open-loop-hysteresis",
        "overall-hysteresis",
        "loop-character",
        "braked-joint",
        "two-axis-settling",
    } <= broken
    assert "dither-motion" in broken
    assert broken <= BRAKE | SETTLING | {"long-term-integral"}


def test_without_dither_only_what_needs_it_fails() -> None:
    on = bench()
    still = replace(on, arm=changed(on.arm, "valve.dither.amplitude", 0.0))
    broken = failed(still)
    assert {"dither-need", "long-term-integral"} <= broken
    assert broken <= DITHER | SETTLING


def test_with_twice_the_payload_only_motion_fails() -> None:
    on = bench()
    broken = failed(replace(on, arm=changed(on.arm, "arm.payload", 2 * on.arm.arm.payload)))
    assert broken
    assert broken <= SETTLING


def test_with_polyester_straps_on_the_new_joint_only_losses_fail() -> None:
    on = bench()
    polyester = load("earlier-actuator").joint["small"].strap
    arm = changed(changed(on.arm, "joint.small.strap", polyester), "joint.large.strap", polyester)
    broken = failed(replace(on, arm=arm))
    assert "open-loop-hysteresis" in broken
    assert "overall-hysteresis" in broken
    assert broken <= LOSSES | SETTLING | {"long-term-integral"}


def test_the_same_bench_gives_the_same_values(paper: Reproduction) -> None:
    again = {claim.id: claim for claim in reproduce(bench()).claims}
    for claim in paper.claims:
        if claim.id != "control-cycle":
            assert again[claim.id] == claim


@pytest.mark.parametrize("name", ["large", "small"])
def test_joints_alone_are_those_of_the_arm(name: str) -> None:
    alone = load(f"paper-{name}-joint")
    assert alone.joints == {name: load("paper-arm").joint[name]}
