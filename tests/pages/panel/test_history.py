"""What is kept for the charts: half a minute, thinned out, of one session."""

from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.pages.panel.pilot import HISTORY_DURATION, HISTORY_PERIOD, History, air_rate
from layflat.physics.air import NORMAL_DENSITY
from layflat.rig.record import RowLayout
from layflat.rig.session import RigSnapshot

ARM = load("paper-arm")
LAYOUT = RowLayout.for_machine(ARM)


def shot(time: float, **values: Any) -> RigSnapshot:
    row = np.zeros(LAYOUT.width)
    for name, value in {"time": time, **values}.items():
        LAYOUT.named(row, name)[...] = value
    return RigSnapshot(LAYOUT, row)


def test_half_a_minute_is_kept_ten_times_a_second() -> None:
    history = History()
    assert history.samples() is None
    for k in range(8000):  # 40 s
        history.add(shot(0.005 * k, averaged_angle=(0.001 * k, 0.0)), ARM)
    seen = history.samples()
    assert seen is not None
    assert seen.times[-1] == 0.0
    assert seen.times[0] == pytest.approx(-HISTORY_DURATION, abs=HISTORY_PERIOD)
    assert np.diff(seen.times) == pytest.approx(HISTORY_PERIOD)
    assert np.diff(seen.joints["averaged_angle"][:, 0]) == pytest.approx(0.02)


def test_another_session_begins_anew() -> None:
    history = History()
    history.add(shot(10.0), ARM)
    history.add(shot(0.1), ARM)
    seen = history.samples()
    assert seen is not None
    assert len(seen.times) == 1
    assert air_rate(seen) == 0.0


def test_air_is_told_by_the_minute() -> None:
    history = History()
    for k in range(101):
        history.add(shot(0.1 * k, estimated_air=0.001 * k * NORMAL_DENSITY / 1000.0), ARM)
    seen = history.samples()
    assert seen is not None
    assert air_rate(seen) == pytest.approx(2 * 0.1 * 60.0 / 10.0)


def test_brakes_are_wholly_on_where_the_control_law_leaves_them_alone() -> None:
    tracking = load("paper-arm-tracking")
    layout = RowLayout.for_machine(tracking)
    row = np.zeros(layout.width)
    layout.named(row, "brake_share")[...] = (0.25, 1.0)
    for machine, shown, wanted in ((ARM, shot(1.0), (1.0, 1.0)), (tracking, RigSnapshot(layout, row), (0.25, 1.0))):
        history = History()
        history.add(shown, machine)
        seen = history.samples()
        assert seen is not None
        assert seen.joints["brake_share"].tolist() == [list(wanted)]


def test_the_worst_lateness_is_of_the_loop_and_not_of_its_start() -> None:
    history = History()
    for time, late in ((0.5, 0.3), (2.0, 1e-4), (3.0, 5e-5)):
        history.add(shot(time, lateness=late), ARM)
    assert history.worst_lateness == 1e-4
