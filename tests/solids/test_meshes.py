"""Triangles of solids enclose their volumes, and their normals look outwards."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from layflat.solids.hardware import sleeve
from layflat.solids.loops import rectangle
from layflat.solids.shapes import Hole, Prism

pytest.importorskip("OCP")

from layflat.solids import cad
from layflat.solids.meshes import Mesh, solid_mesh


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum()) / 6


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        (Prism(rectangle(10.0, 20.0), 30.0), 6000.0),
        (Prism(rectangle(10.0, 20.0), 30.0, (Hole((0.0, 0.0), 6.0),)), 6000.0 - 270.0 * pi),
        (sleeve(20.0, 12.0, 40.0), 40.0 * pi * (100.0 - 36.0)),
    ],
)
def test_a_mesh_encloses_the_volume_of_its_solid(shape: Prism, expected: float) -> None:
    mesh = solid_mesh(cad.solid(shape))
    assert volume(mesh) == pytest.approx(expected, rel=0.01)
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(len(mesh.normals)))
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    for k in range(3):
        assert ((faces * mesh.normals[mesh.triangles[:, k]]).sum(axis=1) > 0).all()


def test_faces_share_no_points_so_that_edges_stay_sharp() -> None:
    mesh = solid_mesh(cad.solid(Prism(rectangle(1.0, 1.0), 1.0)))
    assert mesh.points.shape == (24, 3)
    assert np.abs(mesh.normals).max(axis=1) == pytest.approx(np.ones(24))
