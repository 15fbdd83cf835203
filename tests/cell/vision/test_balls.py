from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.vision.measure import cone_rays, fit_cones, locate_balls, ray_angles, rays_to_balls, rays_to_spheroids

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
    middle, half, on = fit_cones(rays, np.ones((1, 60), bool), np.array([0.05]), np.array([1e-4]))
    middles, radii = locate_balls(middle, half, EYE, 0.0, np.array([height_ratio]), np.ones(1))
    assert on.all()
    assert middles[0] == pytest.approx([x, y, height_ratio * radius], abs=1e-7)
    assert radii[0] == pytest.approx(radius, abs=1e-7)


@given(x=st.floats(0.0, 0.8), y=st.floats(-0.3, 0.3), k=st.floats(0.4, 1.3), ratio=st.floats(0.6, 1.2))
def test_a_flattened_ball_is_found_from_its_outline(x: float, y: float, k: float, ratio: float) -> None:
    """Rays that touch (x/r)^2 + (y/r)^2 + (z/(k r))^2 = 1, by the discriminant of meeting it, are all it takes."""
    radius, middle = 0.03, np.array([x, y, 0.01 + ratio * 0.03])
    size = radius * np.array([1.0, 1.0, k])
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    towards = (middle - EYE) / np.linalg.norm(middle - EYE)
    side = np.cross(towards, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    around = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(side, towards)
    p = (EYE - middle) / size

    def meets(wide: np.ndarray) -> np.ndarray:
        d = (towards + wide[:, None] * around) / size
        return np.asarray((d @ p) ** 2 - (d * d).sum(axis=1) * (p @ p - 1.0) > 0.0)

    low, high = np.zeros(60), np.full(60, 0.3)
    for _ in range(60):
        half = (low + high) / 2.0
        low, high = np.where(meets(half), half, low), np.where(meets(half), high, half)
    rays = towards + low[:, None] * around
    rays = (rays / np.linalg.norm(rays, axis=1, keepdims=True))[None]
    ks = np.array([k])
    assert rays_to_spheroids(rays_to_balls(rays, ks), ks) == pytest.approx(rays, abs=1e-12)
    found, angle, on = fit_cones(rays_to_balls(rays, ks), np.ones((1, 60), bool), np.array([0.05]), np.array([1e-4]))
    middles, radii = locate_balls(found, angle, EYE, 0.01, np.array([ratio]), ks)
    assert on.all()
    assert middles[0] == pytest.approx(middle, abs=1e-6)
    assert radii[0] == pytest.approx(radius, abs=1e-6)


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
    middle, half, on = fit_cones(rays, np.ones((1, 60), bool), np.array([0.03]), np.array([1e-4]))
    middles, radii = locate_balls(middle, half, EYE, 0.0, np.ones(1), np.ones(1))
    assert middles[0, :2] == pytest.approx([0.5, 0.1], abs=2e-4)
    assert radii[0] == pytest.approx(0.03, rel=5e-3)
    assert on[0, ~hidden].all()
    assert on.mean() < 0.85


def test_a_thing_without_edges_is_a_point() -> None:
    rays = outline(0.5, 0.1, 0.03)
    middle, half, on = fit_cones(rays, np.zeros((1, 60), bool), np.array([0.05]), np.array([1e-4]))
    assert np.isfinite(middle).all()
    assert half[0] == 0.0
    assert not on.any()


def test_small_angles_are_exact() -> None:
    rays = outline(0.4, 0.0, 0.01)
    towards = np.array([0.4, 0.0, 0.01]) - EYE
    found = ray_angles(rays, (towards / np.linalg.norm(towards))[None])
    assert found == pytest.approx(np.arcsin(0.01 / np.linalg.norm(towards)), rel=1e-9)
