"""Coarse solids keep a budget of triangles, look as the fine ones do, and are made once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from layflat.machine import load

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("OCP")

from layflat.solids import kept
from layflat.solids.kept import kept_solids
from layflat.solids.moving import MovingSolids, moving_solids


def corners_of(solids: list[MovingSolids]) -> np.ndarray:
    return np.concatenate([corners for one in solids for corners in one.triangles.values()])


@pytest.mark.parametrize(
    ("name", "budget"), [("paper-small-joint", 15_000), ("paper-arm", 15_000), ("paper-arm", 5000)]
)
def test_an_arm_keeps_its_budget_and_its_outline(name: str, budget: int) -> None:
    fine, coarse = moving_solids(load(name)), moving_solids(load(name), budget)
    count = len(corners_of(coarse))
    assert 0.5 * budget < count <= budget
    assert [(one.frame, one.hinge is None) for one in coarse] == [(one.frame, one.hinge is None) for one in fine]
    for one, other in zip(fine, coarse, strict=True):
        ends = [np.concatenate([*each.triangles.values()]).reshape(-1, 3) for each in (one, other)]
        for edge in (np.min, np.max):
            assert edge(ends[1], axis=0) == pytest.approx(edge(ends[0], axis=0), abs=0.004 if budget > 5000 else 0.03)


def test_solids_are_made_once_and_again_for_another_machine_or_a_damaged_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAYFLAT_CACHE_DIR", str(tmp_path))
    made: list[str] = []

    def make(machine: object, budget: int) -> list[MovingSolids]:
        made.append(f"{machine.name} {budget}")  # type: ignore[attr-defined]
        return [MovingSolids(1, None, {"#ffffff": np.full((2, 3, 3), budget, "<f4")})]

    monkeypatch.setattr(kept, "moving_solids", make)
    joint, arm = load("paper-small-joint"), load("paper-arm")
    for machine, budget in ((joint, 100), (joint, 100), (joint, 200), (arm, 200), (joint, 100), (arm, 200)):
        found = kept_solids(machine, budget)
        assert (corners_of(found) == budget).all()
    assert made == ["paper-small-joint 100", "paper-small-joint 200", "paper-arm 200"]
    for file in tmp_path.rglob("*-100.pickle"):
        file.write_bytes(file.read_bytes()[:40])
    kept_solids(joint, 100)
    assert made[3:] == ["paper-small-joint 100"]
    monkeypatch.setenv("LAYFLAT_CACHE_DIR", "/proc/nowhere")
    kept_solids(joint, 100)
    assert made[4:] == ["paper-small-joint 100"]
