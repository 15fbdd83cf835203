"""Figures of runs: the data given are the data drawn; events of a rig keep their labels apart."""

from __future__ import annotations

import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.plot.runs import MAX_MARKS, WARNING_LEVEL, angle_figure, arm_steps, run_figure
from layflat.plot.tuning import response_figure
from tests.plot.looks import covered, cut_off, line_of, looks, units_of

TIME = np.linspace(0.0, 4.0, 401)
JOINTS = ("large", "small")
BAND = np.radians(0.3)


def simulated(shift: float = 0.0) -> xarray.Dataset:
    """A run as the simulation gives it, of two joints."""
    demand = np.stack([np.where(TIME > 1, 0.5, 0.0), np.where(TIME > 2, -0.3, 0.0)], axis=-1)
    angle = demand * (1 - np.exp(-2 * TIME))[:, None] + shift
    flat = {"demand": demand, "angle": angle, "pressure_a": 3e5 + 0 * angle, "pressure_b": 2e5 + 1e5 * angle}
    variables = {name: (("time", "joint"), values) for name, values in {**flat, "voltage": 5 + angle}.items()}
    return xarray.Dataset(variables, coords={"time": TIME, "joint": list(JOINTS)})


def recorded(events: list[tuple[float, int]], fault: tuple[float, float] = (9.0, 9.0)) -> xarray.Dataset:
    """A run as a rig records it: a differential pressure, modes, and events of (time, level)."""
    run = simulated().drop_vars(["pressure_a", "pressure_b"])
    run["measured_pressure"] = (("time", "joint"), 1e5 * simulated()["angle"].to_numpy())
    attributes = {"flag_values": [0, 1, 2], "flag_meanings": "idle active fault"}
    run["mode"] = ("time", np.where((fault[0] <= TIME) & (fault[1] >= TIME), 2, 1), attributes)
    run["event_time"] = ("event", [at for at, _ in events])
    run["event_level"] = ("event", [level for _, level in events])
    run["event_text"] = ("event", [f"what happened at {at:.2f}" for at, _ in events])
    return run


def test_a_run_shows_what_was_simulated() -> None:
    run = simulated()
    made = run_figure(run)
    assert len(made.axes) == 6
    for column, joint in enumerate(JOINTS):
        angle, pressure, voltage = (made.axes[2 * row + column] for row in range(3))
        assert angle.get_title() == f"{joint} joint"
        part = run.sel(joint=joint)
        np.testing.assert_allclose(line_of(angle, "angle")[1], np.degrees(part["angle"]))
        np.testing.assert_allclose(line_of(angle, "demand")[1], np.degrees(part["demand"]))
        np.testing.assert_allclose(line_of(pressure, "hose B")[1], part["pressure_b"] / 1e5)
        np.testing.assert_allclose(np.asarray(voltage.lines[0].get_ydata(), dtype=float), part["voltage"])
        assert len(set(looks(angle))) == len(set(looks(pressure))) == 2


def test_what_is_at_rest_looks_at_rest_and_its_axis_keeps_its_name() -> None:
    run = simulated()
    run["angle"][:], run["demand"][:], run["voltage"][:] = 0.0, 0.0, 5.0 + 1e-4 * np.sin(TIME)[:, None]
    made = run_figure(run)
    for axes in (*made.axes[:2], *made.axes[4:]):
        assert np.ptp(axes.get_ylim()) >= 0.49
        named = axes.yaxis.get_tightbbox()
        assert named is not None
        assert named.x0 >= 0.0


def test_every_figure_of_runs_has_units_and_readable_texts() -> None:
    run, other = simulated(), simulated(0.01)
    for made in (
        run_figure(run),
        run_figure(recorded([(1.0, WARNING_LEVEL), (3.0, WARNING_LEVEL)])),
        angle_figure({"one": run, "other": other}, "small", band=BAND),
        arm_steps(run, band=BAND),
        response_figure({"before": run, "after": other}, band=BAND, since=1.0),
    ):
        assert all(label.endswith(")") for label in units_of(made))
        assert all(axes.get_ylabel() for axes in made.axes)
        assert covered(made) == []
        assert cut_off(made) == []


def test_a_rig_that_knows_one_pressure_shows_the_difference() -> None:
    made = run_figure(recorded([]))
    assert made.axes[2].get_ylabel() == "Differential pressure (bar)"
    np.testing.assert_allclose(line_of(made.axes[2], "hose A less hose B")[1], simulated()["angle"].sel(joint="large"))


times = st.lists(st.one_of(st.floats(0.0, 4.0), st.sampled_from([1.0, 1.01, 3.9, 4.0])), min_size=1, max_size=MAX_MARKS)


@settings(deadline=None, max_examples=6)
@given(times=times)
def test_events_never_hide_each_others_labels(times: list[float]) -> None:
    made = run_figure(recorded([(at, WARNING_LEVEL) for at in sorted(times)]).isel(joint=[0]))
    assert covered(made) == []
    for axes in made.axes[-1:]:
        ends = [[int(end) for end in text.get_text().split("–")] for text in axes.texts]
        told = [number for first, *_, last in ((*pair, pair[-1]) for pair in ends) for number in range(first, last + 1)]
        assert told == list(range(1, len(times) + 1))
        assert sum(line.get_color() == "#555555" for line in axes.lines) == len(times)
    notes = [text.get_text() for text in made.texts]
    assert sorted(notes) == sorted(
        f"{number}: at {at:.2f} s, what happened at {at:.2f}" for number, at in enumerate(sorted(times), 1)
    )


def test_only_warnings_and_errors_are_marked_and_not_more_than_can_be_told_apart() -> None:
    quiet = run_figure(recorded([(0.5, WARNING_LEVEL - 10), (1.0, WARNING_LEVEL)]))
    assert [text.get_text() for text in quiet.texts] == ["2: at 1.00 s, what happened at 1.00"]
    many = run_figure(recorded([(0.1 * i, WARNING_LEVEL) for i in range(30)]))
    assert len(many.texts) == MAX_MARKS
    assert run_figure(simulated()).texts == []


def test_a_fault_is_shaded_where_it_lasts_and_named() -> None:
    made = run_figure(recorded([], fault=(1.5, 2.5)))
    for axes in made.axes:
        (shade,) = axes.collections
        spans = [path.get_extents() for path in shade.get_paths()]
        assert [(round(span.x0, 2), round(span.x1, 2)) for span in spans] == [(1.5, 2.5)]
    legend = made.axes[0].get_legend()
    assert legend is not None
    assert "fault" in [text.get_text() for text in legend.get_texts()]


def test_angles_of_several_runs_share_one_demand_and_time_counts_from_the_move() -> None:
    runs = {f"run {i}": simulated(0.01 * i) for i in range(3)}
    (axes,) = angle_figure(runs, "large", since=1.0, band=BAND).axes
    assert len(set(looks(axes))) == 4
    for label, run in runs.items():
        time, angle = line_of(axes, label)
        np.testing.assert_allclose(time, TIME - 1.0)
        np.testing.assert_allclose(angle, np.degrees(run["angle"].sel(joint="large")))
    legend = axes.get_legend()
    assert legend is not None
    assert "demand ±0.3 deg" in [text.get_text() for text in legend.get_texts()]


def test_steps_of_an_arm_show_the_error_over_the_band_it_settles_in() -> None:
    run = simulated()
    angle, error = arm_steps(run, band=BAND).axes
    for joint in JOINTS:
        part = run.sel(joint=joint)
        np.testing.assert_allclose(line_of(error, f"{joint} joint")[1], np.degrees(part["angle"] - part["demand"]))
        np.testing.assert_allclose(line_of(angle, f"{joint} joint")[1], np.degrees(part["angle"]))
    (band,) = error.patches
    assert band.get_extents().transformed(error.transData.inverted()).intervaly == pytest.approx([-0.3, 0.3])
    legend = error.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["±0.3 deg"]
