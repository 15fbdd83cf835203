"""The paper's claims: they agree, they can fail, and what a machine lacks is said."""

from dataclasses import replace

import pytest

from layflat.experiments import Reproduction, ReproductionBench, axis_one, load_bench, reproduce
from layflat.experiments.claim import PAPER_CLAIMS, Claim
from layflat.experiments.report import evaluate_other_claims
from layflat.experiments.reproduction import CLAIM_IDS, STOPPED_REASON
from layflat.machine import changed, load

STATICS = {
    "table-1", "mean-torque", "large-joint-torque", "small-joint-torque", "torque-per-mass", "constant-torque",
}  # fmt: skip
SETTLING = {"unbraked-joint", "braked-joint", "two-axis-settling", "repeatability", "coupling"}
BRAKE = {"open-loop-hysteresis", "loop-character", "overall-hysteresis", "dither-motion"}
DITHER = {"dither-motion", "dither-need", "long-term-integral"}
LOSSES = {"open-loop-hysteresis", "overall-hysteresis", "loop-character"}
TWO_JOINTS = {"torque-per-mass", "two-axis-settling", "repeatability", "coupling", "overall-hysteresis"}
LARGE = {"mean-torque", "large-joint-torque", "constant-torque"}


@pytest.fixture
def _one_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits of inertia are sought with one seed of the noise instead of five."""
    monkeypatch.setattr(axis_one, "SEED_COUNT", 1)


def failed(on: ReproductionBench) -> set[str]:
    return {claim.id for claim in reproduce(on).claims if not claim.agrees}


def test_all_twenty_claims_agree(paper: Reproduction) -> None:
    assert [claim.id for claim in paper.claims] == list(CLAIM_IDS)
    assert len(CLAIM_IDS) == 20
    assert [claim.id for claim in paper.claims if not claim.agrees] == []
    assert paper.summary == "20 of 20 claims agree"


def test_the_papers_value_stands_beside_what_is_simulated(paper: Reproduction) -> None:
    given = {claim.id: {one.name: one.paper for one in claim.quantities} for claim in paper.claims}
    assert given["open-loop-hysteresis"] == {"earlier": "25", "new": "7", "new with brake": "25"}
    assert given["large-joint-torque"] == {"maximum torque": "84"}
    assert given["torque-per-mass"]["mean"] == "3.5"
    assert all(any(names.values()) for names in given.values())
    assert not any("(" in name for names in given.values() for name in names), "units stand in a column of their own"


@pytest.mark.usefixtures("_one_seed")
def test_without_brake_only_what_needs_it_fails() -> None:
    broken = failed(replace(load_bench(), brake=0.0))
    assert {
        "open-loop-hysteresis",
        "overall-hysteresis",
        "loop-character",
        "braked-joint",
        "two-axis-settling",
    } <= broken
    assert "dither-motion" in broken
    assert broken <= BRAKE | SETTLING | {"long-term-integral"}


@pytest.mark.usefixtures("_one_seed")
def test_without_dither_only_what_needs_it_fails() -> None:
    on = load_bench()
    still = replace(on, arm=changed(on.arm, "valve.dither.amplitude", 0.0))
    broken = failed(still)
    assert {"dither-need", "long-term-integral"} <= broken
    assert broken <= DITHER | SETTLING


@pytest.mark.usefixtures("_one_seed")
def test_with_twice_the_payload_only_motion_fails() -> None:
    on = load_bench()
    broken = failed(replace(on, arm=changed(on.arm, "arm.payload", 2 * on.arm.arm.payload)))
    assert broken
    assert broken <= SETTLING


@pytest.mark.usefixtures("_one_seed")
def test_with_polyester_straps_on_the_new_joint_only_losses_fail() -> None:
    on = load_bench()
    polyester = load("earlier-actuator").joint["small"].strap
    arm = changed(changed(on.arm, "joint.small.strap", polyester), "joint.large.strap", polyester)
    broken = failed(replace(on, arm=arm))
    assert "open-loop-hysteresis" in broken
    assert "overall-hysteresis" in broken
    assert broken <= LOSSES | SETTLING | {"long-term-integral"}


def by_id(found: Reproduction) -> dict[str, Claim]:
    return {claim.id: claim for claim in found.claims}


def test_a_machine_of_one_joint_is_judged_by_what_it_has(paper: Reproduction) -> None:
    found = reproduce(load_bench("paper-small-joint"))
    lacking = {claim.id: claim.reason for claim in found.claims if claim.agrees is None}
    assert lacking.keys() == TWO_JOINTS | LARGE
    assert set(lacking.values()) == {"not applicable: paper-small-joint: has no joint 'large'"}
    assert found.agrees
    assert found.summary == "12 of 12 claims agree; 8 do not apply to this machine"
    for name in ("small-joint-torque", "unbraked-joint", "braked-joint", "long-term-integral"):
        assert by_id(found)[name] == by_id(paper)[name], "axis one is the arm's small joint, alone"


@pytest.mark.usefixtures("_one_seed")
def test_a_rig_without_valve_and_controller_has_its_statics() -> None:
    found = by_id(reproduce(load_bench("rig-kevlar")))
    evaluated = {name for name, claim in found.items() if claim.agrees is not None}
    assert evaluated == {"table-1", "small-joint-torque", "open-loop-hysteresis", "loop-character", "rig-variants"}
    assert found["dither-need"].reason == "not applicable: rig-kevlar: has no spool valve"
    assert "rig-kevlar: has no valve" in found["control-cycle"].reason


def test_an_interruption_keeps_what_was_evaluated() -> None:
    def two(done: int, total: int) -> None:
        assert total == 20
        if done == 2:
            raise KeyboardInterrupt

    found = reproduce(load_bench(), progress=two)
    assert found.was_interrupted
    assert [claim.id for claim in found.evaluated] == ["table-1", "mean-torque"]
    assert [claim.id for claim in found.claims] == list(CLAIM_IDS)
    assert {claim.reason for claim in found.claims[2:]} == {STOPPED_REASON}
    assert found.summary == "2 of 2 claims agree; partial: stopped before 18 were evaluated"


def test_what_another_process_evaluates_is_taken_and_the_rest_is_evaluated_here(paper: Reproduction) -> None:
    others = list(evaluate_other_claims("paper-arm"))
    assert [type(one).__name__ for one in others] == 5 * ["Claim"] + 10 * ["CaptionedFigure"]
    for given, drawn in ((others, 10), (others[:2], 0)):
        found = by_id(whole := reproduce(load_bench(), others=given))
        assert list(found) == list(CLAIM_IDS)
        assert len(whole.drawn) == drawn
        assert all(found[claim.id] == claim for claim in paper.claims if claim.id != "control-cycle")


def test_the_same_bench_gives_the_same_values(paper: Reproduction) -> None:
    again = by_id(reproduce(load_bench()))
    for claim in paper.claims:
        if claim.id != "control-cycle":
            assert again[claim.id] == claim


@pytest.mark.parametrize("name", ["large", "small"])
def test_joints_alone_are_those_of_the_arm_but_for_the_gains(name: str) -> None:
    alone, arm = (load(one).joint[name] for one in (f"paper-{name}-joint", "paper-arm"))
    assert alone.model_copy(update={"gains": arm.gains}) == arm


@pytest.mark.parametrize("chosen", [["table-1"], ["table-1", "unbraked-joint"], ["braked-joint"]])
def test_claims_that_are_not_chosen_do_not_count(chosen: list[str]) -> None:
    steps: list[tuple[int, int]] = []
    others = [replace(PAPER_CLAIMS[key], agrees=True) for key in ("unbraked-joint", "braked-joint", "loop-character")]
    found = reproduce(claims=chosen, others=others, progress=lambda done, total: steps.append((done, total)))
    assert steps == [(done, len(chosen)) for done in range(1, len(chosen) + 1)]
    assert [claim.id for claim in found.claims] == chosen
