"""Distances of triangles against closed forms and the CAD kernel's own distances."""

import numpy as np
import pytest

from layflat import extras
from layflat.solids import cad
from layflat.solids.checks.meshes import (
    CHORD_TOLERANCE,
    MeshStore,
    PartMesh,
    box_gaps,
    least_distance,
    segment_distances,
)
from layflat.solids.checks.meshes import triangle_distances as distances
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import rod, sleeve
from layflat.solids.loops import rectangle
from layflat.solids.shapes import PartPlace, Prism, Shape

FLAT = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]])


def test_triangles_above_across_and_through_each_other() -> None:
    upright = np.array([[[1.0, 1.0, 2.0], [1.0, 1.0, 5.0], [2.0, 1.0, 5.0]]])
    assert distances(FLAT, upright) == pytest.approx([2.0])
    assert distances(FLAT, FLAT + np.array([10.0, 0.0, 0.0])) == pytest.approx([6.0])
    assert distances(FLAT, upright - np.array([0.0, 0.0, 3.0])) == pytest.approx([0.0])
    assert distances(upright, FLAT) == pytest.approx([2.0])


def test_segments_that_are_skew_parallel_or_points() -> None:
    one = np.array([[0.0, 0.0, 0.0]]), np.array([[2.0, 0.0, 0.0]])
    cases = [((1.0, -1.0, 3.0), (1.0, 1.0, 3.0), 3.0), ((0.5, 2.0, 0.0), (5.0, 2.0, 0.0), 2.0),
             ((5.0, 4.0, 0.0), (5.0, 4.0, 0.0), 5.0)]  # fmt: skip
    for start, end, distance in cases:
        assert segment_distances(*one, np.array([start]), np.array([end])) == pytest.approx([distance])


@pytest.mark.skipif(not extras.available("cad"), reason="no build123d; pip install layflat[cad]")
def test_distances_are_those_of_the_kernel_within_the_tolerance_of_the_triangles() -> None:
    random, store = np.random.default_rng(3), MeshStore()
    shapes: list[Shape] = [rod(8.0, 20.0), Prism(rectangle(10.0, 6.0), 14.0), sleeve(12.0, 8.0, 5.0)]
    near = 0
    for _ in range(40):
        first, second = (
            Component("part", "body", shapes[k], "steel", "turning", (
                PartPlace(axes_towards(*random.normal(size=3)), random.uniform(-12.0, 12.0, 3)),))
            for k in random.integers(0, 3, 2)
        )  # fmt: skip
        bodies = [cad.placed(cad.solid(one.shape), one.places[0]) for one in (first, second)]
        true = float(bodies[0].distance_to(bodies[1]))
        inside = true == 0.0
        found = least_distance(store.parts([first])[0], store.parts([second])[0], 5.0)
        near += 0.0 < true < 4.8
        if not inside and true < 4.8:
            assert abs(found - true) <= 2 * CHORD_TOLERANCE
        if true > 5.0:
            assert found == np.inf
    assert near > 5


def test_gaps_of_boxes_are_the_largest_over_the_axes() -> None:
    part = Component("part", "body", rod(1.0, 1.0), "steel", "turning", ())
    first, second = PartMesh(part, FLAT), PartMesh(part, FLAT + np.array([7.0, 1.0, 2.0]))
    assert box_gaps([first], [second]) == pytest.approx(np.array([[3.0]]))
