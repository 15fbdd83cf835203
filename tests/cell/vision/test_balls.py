from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.vision.balls import angles, cone_rays, fit_cones, place

EYE = np.array([0.4, 0.0, 1.0])


def outline(x: float, y: float, radius: float, height_ratio: float = 1.0, count: int = 60) -> np.ndarray:
    """Rays that touch a ball, by the definition: as far from its middle as it is wide."""
    towards = np.array([x, y, height_ratio * radius]) - EYE
    far = np.linalg.norm(towards)
    return cone_rays((towards / far)[None], np.array([np.arcsin(radius / far)]), count)


def miss(rays: np.ndarray, middle: np.ndarray) -> np.ndarray:
    towards = middle - EYE
    return np.asarray(np.linalg.norm(np.cross(rays, towards), axis=-1))


@given(x=st.floats(0.0, 0.8), y=st.floats(-0.3, 0.3), radius=st.floats(0.01, 0.06), height_ratio=st.floats(0.6, 1.2))
def test_a_ball_is_found_from_its_outline(x: float, y: float, radius: float, height_ratio: float) -> None:
    rays = outline(x, y, radius, height_ratio)
    assert miss(rays, np.array([x, y, height_ratio * radius])) == pytest.approx(radius, rel=1e-9)
    middle, half, on = fit_cones(rays, np.ones((1, 60), bool), np.array([0.05]), 1e-4)
    middles, radii = place(middle, half, EYE, 0.0, np.array([height_ratio]))
    assert on.all()
    assert middles[0] == pytest.approx([x, y, height_ratio * radius], abs=1e-7)
    assert radii[0] == pytest.approx(radius, abs=1e-7)


def test_the_outline_is_not_at_the_middles_height() -> None:
    """Whoever takes the outline for a circle on the table is wrong by millimetres: what the exact geometry is for."""
    rays = outline(0.75, 0.2, 0.035)[0]
    foot = EYE[:2] - EYE[2] / rays[:, 2:] * rays[:, :2]
    assert np.linalg.norm(foot.mean(axis=0) - [0.75, 0.2]) > 0.01


def test_rays_that_are_off_are_left_out() -> None:
    rng = np.random.default_rng(3)
    rays = outline(0.5, 0.1, 0.03)
    hidden = np.arange(60) < 18
    other = outline(0.52, 0.1, 0.02)
    rays[0, hidden] = other[0, hidden]
    rays += rng.normal(0.0, 1e-5, rays.shape)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    middle, half, on = fit_cones(rays, np.ones((1, 60), bool), np.array([0.03]), 1e-4)
    middles, radii = place(middle, half, EYE, 0.0, np.ones(1))
    assert middles[0, :2] == pytest.approx([0.5, 0.1], abs=2e-4)
    assert radii[0] == pytest.approx(0.03, rel=5e-3)
    assert on[0, ~hidden].all()
    assert on.mean() < 0.85


def test_a_thing_without_edges_is_a_point() -> None:
    rays = outline(0.5, 0.1, 0.03)
    middle, half, on = fit_cones(rays, np.zeros((1, 60), bool), np.array([0.05]), 1e-4)
    assert np.isfinite(middle).all()
    assert half[0] == 0.0
    assert not on.any()


def test_small_angles_are_exact() -> None:
    rays = outline(0.4, 0.0, 0.01)
    towards = np.array([0.4, 0.0, 0.01]) - EYE
    found = angles(rays, (towards / np.linalg.norm(towards))[None])
    assert found == pytest.approx(np.arcsin(0.01 / np.linalg.norm(towards)), rel=1e-9)
