"""Solids of a scene are where an assembly at the same angles has them, and hold the volume of its parts."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
import pytest

from layflat.bridge.pieces import rigid_arm
from layflat.machine import Machine, load

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("OCP")

from layflat.solids.assembly import assemble
from layflat.solids.kernel import box, integrals
from layflat.solids.moving import SMALL_PARTS, MovingSolids, moving_solids
from layflat.solids.sizes import MM

ANGLES = {"paper-arm": [0.4, -0.3], "paper-small-joint": [-0.5]}


def volume(corners: np.ndarray) -> float:
    """Volume within triangles, of any place."""
    a, b, c = corners.astype(float).transpose(1, 0, 2)
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6)


def shown(machine: Machine, solids: list[MovingSolids], angles: list[float]) -> np.ndarray:
    """Corners of all triangles in the frame of the base, m."""
    frames = [(np.eye(3), np.zeros(3)), *rigid_arm(machine).poses(angles)]
    found = []
    for one in solids:
        axes, origin = one.pose(frames, angles)
        found += [corners.reshape(-1, 3) @ axes.T + origin for corners in one.triangles.values()]
    return np.concatenate(found)


@pytest.mark.parametrize("name", ANGLES)
def test_solids_move_to_where_an_assembly_at_these_angles_has_them(name: str) -> None:
    machine = load(name)
    solids, angles = moving_solids(machine), ANGLES[name]
    assembly = assemble(machine, angles)
    bodies = [body for part, _, body in assembly.bodies()
              if not part.group.startswith("hose") and not part.name.startswith(SMALL_PARTS)]  # fmt: skip
    total = sum(volume(corners) for one in solids for corners in one.triangles.values())
    assert total * MM**3 == pytest.approx(sum(integrals(body).volume for body in bodies), rel=0.03)
    boxes = np.array([box(body) for body in bodies]) / MM
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    corners = shown(machine, solids, angles)
    assert corners.min(axis=0) == pytest.approx(low, abs=1.5e-3)
    assert corners.max(axis=0) == pytest.approx(high, abs=1.5e-3)


@pytest.mark.parametrize("angle", [-0.6, 0.3])
def test_shells_turn_about_their_hinges_as_in_the_assembly(angle: float) -> None:
    machine = load("paper-small-joint")
    hinges = [one.hinge for one in moving_solids(machine) if one.hinge is not None]
    far = np.array([30.0, 60.0, 10.0])
    for name, hinge in zip(("shell A", "shell B"), hinges, strict=True):
        (before, after) = (
            next(part.places[0] for part in assemble(machine, angles).components if part.name == name)
            for angles in ([0.0], [angle])
        )
        axes, origin = hinge.pose(angle)
        moved = origin + axes @ (before.origin + before.axes @ far) / MM
        assert moved == pytest.approx((after.origin + after.axes @ far) / MM, abs=1e-5)


def test_a_changed_joint_is_there_soon(tmp_path: Path) -> None:
    (tmp_path / "wide.toml").write_text(
        'extends = "paper-arm"\nname = "wide"\n[joint.large.hose]\nwidth = "170 mm"\n', encoding="utf-8"
    )
    before = moving_solids(load("paper-arm"))
    wide = load(str(tmp_path / "wide.toml"))
    begun = time.perf_counter()
    after = moving_solids(wide)
    seconds = time.perf_counter() - begun
    assert seconds < 8.0, seconds  # beside other tests: 2 s on a computer that does nothing else
    assert sum(len(one.triangles) for one in after) == sum(len(one.triangles) for one in before)
