"""The figure of the cam: its lines touch the profile, and the axis' name lies clear of both."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from layflat.design import Cam, SizingRequest, design_joint, size_joint
from layflat.plot.curves import DRAWN_STRAP_LINES, cam_procedure
from tests.plot.looks import covered, crossed_by_lines, cut_off, line_of, looks, units_of

CAMS = {
    "large": design_joint("paper-arm", "large").with_cam(),
    "small": design_joint("paper-arm", "small").with_cam(),
    "short stroke": size_joint(SizingRequest(8.0, radians(90), 2.5e5)).design.with_cam(),
    "long stroke": size_joint(SizingRequest(60.0, radians(160), 5e5)).design.with_cam(),
}
each_cam = pytest.mark.parametrize("cam", CAMS.values(), ids=CAMS)


@each_cam
def test_every_strap_line_touches_the_profile_and_does_not_cut_it(cam: Cam) -> None:
    (axes,) = cam_procedure(cam).axes
    unnamed = [line for line in axes.lines if str(line.get_label()).startswith("_")]
    straps = [line for line in unnamed if np.shape(line.get_xydata()) == (3, 2)]
    assert len(straps) == DRAWN_STRAP_LINES
    for line in straps:
        start, touch, end = np.asarray(line.get_xydata())
        along = (end - start) / np.hypot(*(end - start))
        beside = (1e3 * cam.profile - start) @ np.array([-along[1], along[0]])
        assert abs(np.abs(beside).min()) < 1e-6
        assert beside.max() < 1e-6 or beside.min() > -1e-6
        assert np.abs(1e3 * cam.profile - touch).sum(axis=1).min() < 1e-9


@each_cam
def test_strap_point_keeps_its_distance_from_the_axis(cam: Cam) -> None:
    (axes,) = cam_procedure(cam).axes
    seen = np.hypot(*line_of(axes, "where the strap leaves the shell"))
    np.testing.assert_allclose(seen, 1e3 * np.hypot(*(cam.strap_point - np.array(cam.axis)).T), rtol=1e-12)
    np.testing.assert_array_equal(np.stack(line_of(axes, "cam profile"), axis=-1), 1e3 * cam.profile)


@each_cam
def test_nothing_runs_through_the_name_of_the_axis(cam: Cam) -> None:
    made = cam_procedure(cam)
    assert not crossed_by_lines(made.axes[0], "output axis")
    assert covered(made) == []
    assert cut_off(made) == []


def test_both_axes_have_the_same_scale_and_their_unit() -> None:
    made = cam_procedure(CAMS["large"])
    assert made.axes[0].get_aspect() == 1.0
    assert all(label.endswith("(mm)") for label in units_of(made))
    assert len(set(looks(made.axes[0]))) == 2
