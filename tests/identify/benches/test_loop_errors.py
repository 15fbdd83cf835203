from types import SimpleNamespace

import numpy as np
import pytest

from layflat.identify.benches.hysteresis import curve_errors, loop_height, motion_directions

T = np.linspace(0.0, 3.0, 3001)
X = np.sin(2 * np.pi * T)
WAY = np.sign(np.cos(2 * np.pi * T))


def test_height_of_a_rectangle_is_its_height() -> None:
    assert loop_height(X, 7.0 + 2.5 * WAY) == pytest.approx(5.0, rel=1e-3)
    assert loop_height(X, 7.0 - 2.5 * WAY) == pytest.approx(5.0, rel=1e-3)


def test_what_depends_on_position_alone_adds_little() -> None:
    assert loop_height(X, 40.0 * X**3 + 2.5 * WAY) == pytest.approx(5.0, rel=0.02)
    assert loop_height(X, 40.0 * X**3) < 0.1


def test_uneven_sampling_and_noise_do_not_matter() -> None:
    rng = np.random.default_rng(1)
    kept = np.sort(rng.choice(len(T), 1500, replace=False))
    noisy = X[kept] + rng.normal(0.0, 0.01, len(kept))
    assert loop_height(noisy, 2.5 * WAY[kept]) == pytest.approx(5.0, rel=0.01)


def test_samples_that_are_no_numbers_are_left_out() -> None:
    effort = 2.5 * WAY
    effort[100:200] = np.nan
    assert loop_height(X, effort) == pytest.approx(5.0, rel=1e-3)


def test_noise_does_not_turn_the_way() -> None:
    noisy = X + np.random.default_rng(0).normal(0.0, 0.005, len(X))
    turned = np.flatnonzero(np.diff(motion_directions(noisy)))
    assert len(turned) == 6
    assert T[turned] == pytest.approx(0.25 + 0.5 * np.arange(6), abs=0.04)


def test_a_motion_without_a_way_back_has_no_height() -> None:
    assert loop_height(T, T) == 0.0


def test_errors_of_a_curve_without_height_are_infinitely_many_times_its_height() -> None:
    measured = np.ones(len(T))
    output = SimpleNamespace(log="one way", measured=measured, fitted=np.ones(len(T), bool))
    model = SimpleNamespace(slices=[slice(None)], outputs=[output], motions=[T])
    (error,) = curve_errors(model, measured + 0.1)  # type: ignore[arg-type]
    assert (error.height, error.raw, error.friction) == (0.0, np.inf, np.inf)
