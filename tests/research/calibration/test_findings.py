"""A machine is judged no further than to where it lacks too much."""

from dataclasses import replace

import numpy as np
import pytest

from layflat.experiments.bench import load_bench
from layflat.experiments.claim import PAPER_CLAIMS
from research.calibration.effort import (
    EXACT_CLAIM_EFFORT,
    LOOK_SEED_STRIDE,
    OWN_NOISE,
    ROUGH_CLAIM_EFFORT,
    ROUGH_EFFORT,
)
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.cloud.held_out import FINDINGS
from research.cloud.open import ALONE, ARM, built_in_shares, values

pytestmark = pytest.mark.compiled
FEW = replace(ROUGH_EFFORT, most=np.inf)
OURS = {"joint is held short of its goal", "arm overshoots"}
"""What no finding says, but who tunes an arm sees to."""


@pytest.fixture(scope="module")
def findings() -> Findings:
    return Findings(Evidence(load_bench()))


@pytest.fixture(scope="module")
def shares() -> np.ndarray:
    rng = np.random.default_rng(2)
    return np.clip(built_in_shares() + 0.1 * rng.standard_normal((4, len(built_in_shares()))), 0.0, 1.0)


@pytest.mark.parametrize("part", [ALONE, ARM])
def test_what_is_lacked_is_the_sum_of_its_parts_up_to_a_level(
    findings: Findings, shares: np.ndarray, part: int
) -> None:
    arm = part == ARM
    parts = findings.parts(shares, lambda some: values(some, part), arm=arm, seed=3, effort=ROUGH_EFFORT)
    counted = {name: ROUGH_EFFORT.counted(one) for name, one in parts.items()}
    whole = np.sum(list(counted.values()), axis=0)
    assert np.all(whole >= 0.0)
    for level in (np.inf, np.median(whole)):
        found = findings.lack(
            shares, lambda some: values(some, part), arm=arm, seed=3, effort=ROUGH_EFFORT, level=np.full(4, level)
        )
        below = whole <= level
        assert found[below] == pytest.approx(whole[below])
        assert np.all(found[~below] > level)
        assert np.all(found[~below] <= whole[~below] + 1e-12)
    name = max(parts, key=lambda one: parts[one].sum())
    without = Findings(findings.evidence, frozenset([name]))
    found = without.lack(shares, lambda some: values(some, part), arm=arm, seed=3, effort=ROUGH_EFFORT, level=np.inf)
    assert found == pytest.approx(whole - counted[name])


@pytest.mark.parametrize("part", [ALONE, ARM])
def test_of_several_looks_the_worst_counts(findings: Findings, shares: np.ndarray, part: int) -> None:
    def by_path(some: np.ndarray) -> dict[str, np.ndarray]:
        return values(some, part)

    each = [
        np.sum([ROUGH_EFFORT.counted(one) for one in parts.values()], axis=0)
        for seed in (3, 3 + LOOK_SEED_STRIDE)
        for parts in [findings.parts(shares, by_path, arm=part == ARM, seed=seed, effort=ROUGH_EFFORT)]
    ]
    assert not np.array_equal(*each)
    effort = replace(ROUGH_EFFORT, looks=2)
    found = findings.lack(shares, by_path, arm=part == ARM, seed=3, effort=effort, level=np.inf)
    assert found == pytest.approx(np.maximum(*each))


def test_the_claims_own_runs_may_count_as_well(findings: Findings, shares: np.ndarray) -> None:
    def by_path(some: np.ndarray) -> dict[str, np.ndarray]:
        return values(some, ARM)

    once, own = (
        np.sum(list(findings.parts(shares, by_path, arm=True, seed=seed, effort=effort).values()), axis=0)
        for seed, effort in ((3, FEW), (OWN_NOISE, EXACT_CLAIM_EFFORT))
    )
    assert not np.array_equal(once, own)
    effort = replace(FEW, claimed=True)
    found = findings.lack(shares, by_path, arm=True, seed=3, effort=effort, level=np.inf)
    assert found == pytest.approx(np.maximum(once, own))


def test_every_finding_can_be_left_out(findings: Findings, shares: np.ndarray) -> None:
    known, effort = set[str](), replace(ROUGH_EFFORT, learns=True)
    for part in (ALONE, ARM):
        by_path = values(shares[:1], part)
        known |= set(findings.parts(shares[:1], lambda _, same=by_path: same, arm=part == ARM, seed=3, effort=effort))  # type: ignore[misc]
    assert {name for finding in FINDINGS for name in finding.shortfalls} == known - OURS
    assert {finding.claim for finding in FINDINGS} <= set(PAPER_CLAIMS)


def test_far_from_all_no_finding_counts_for_more_than_some() -> None:
    lacked = np.array([0.0, 0.01, 1.0, 10.0, 1e6])
    counted = ROUGH_EFFORT.counted(lacked)
    assert np.all(np.diff(counted) > 0.0)
    assert np.all(counted <= ROUGH_EFFORT.most)
    assert counted[:2] == pytest.approx(lacked[:2], rel=0.01)
    assert np.array_equal(ROUGH_CLAIM_EFFORT.counted(lacked), lacked)
