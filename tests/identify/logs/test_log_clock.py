"""Clocks that jitter, repeat, stop and jump, and what becomes of the samples."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.identify.logs import find_issues, read_log
from layflat.identify.logs.grid import GAP_PERIODS, SignalSeries, build_clock, build_grid, resample
from tests.identify.logs.recordings import Array, ticks, write_csv


def series(signal: str, time: Array, values: Array) -> SignalSeries:
    clock = build_clock(np.asarray(time, dtype=float), "log")
    return SignalSeries(signal, None, clock, np.asarray(values, dtype=float)[clock.rows], {})


@st.composite
def jittered(draw: st.DrawFn) -> Array:
    period = draw(st.sampled_from([1e-3, 5e-3, 1.0 / 30.0]))
    size = draw(st.integers(20, 200))
    rng = np.random.default_rng(draw(st.integers(0, 1000)))
    time: Array = period * (ticks(1.0, size) + rng.uniform(-0.4, 0.4, size))
    return time + draw(st.sampled_from([0.0, 1e3, 1.7e9]))


@settings(max_examples=40)
@given(time=jittered(), slope=st.floats(-5, 5), cycle=st.sampled_from([None, 2e-3]))
def test_what_moves_in_a_line_is_not_bent_by_jitter(time: Array, slope: float, cycle: float | None) -> None:
    grid = build_grid([build_clock(time, "log")], cycle, "log")
    values = resample(series("force", time, slope * (time - time[0])), grid)
    known = np.isfinite(values)
    assert values[known] == pytest.approx(slope * grid.time[known], abs=1e-5)
    assert known.mean() > 0.7  # even jitter of 0.8 periods makes no gap of more than GAP periods
    assert grid.period == (cycle or pytest.approx(np.median(np.diff(time))))


@settings(max_examples=40)
@given(time=jittered())
def test_a_command_holds_its_last_value_and_no_other(time: Array) -> None:
    levels = np.arange(time.size, dtype=float)
    grid = build_grid([build_clock(time, "log")], None, "log")
    held = resample(series("voltage", time, levels), grid)
    for stamp, value in zip(grid.stamps, held, strict=True):
        assert time[int(value)] <= stamp + 1e-6 * grid.period + 1e-6
        assert value == levels[-1] or time[int(value) + 1] > stamp


def test_an_even_log_stays_as_it_is() -> None:
    time = ticks(0.005, 100)
    values = np.random.default_rng(0).normal(size=100)
    for cycle in (None, 0.005):
        grid = build_grid([build_clock(time, "log")], cycle, "log")
        assert np.array_equal(resample(series("force", time, values), grid), values)
        assert np.array_equal(resample(series("voltage", time, values), grid), values)


def test_a_log_with_samples_lost_lies_on_the_grid_of_the_others() -> None:
    time = np.delete(ticks(0.005, 200), [7, 8, 30, 31, 32, 33, 34, 35, 36, 37])
    clock = build_clock(time, "log")
    assert clock.period == pytest.approx(0.005, rel=1e-12)
    assert clock.jitter == 0.0
    values = resample(series("force", time, 2.0 * time), build_grid([clock], None, "log"))
    assert np.flatnonzero(np.isnan(values)).tolist() == list(range(30, 38))
    assert values[7:9] == pytest.approx([0.07, 0.08])  # a few lost ones are no gap


@pytest.mark.parametrize("lost", [1, 3, 4, 20])
def test_missing_values_are_filled_up_to_three_and_left_open_beyond(lost: int) -> None:
    time = ticks(0.01, 100)
    values = 3.0 * time
    values[40 : 40 + lost] = np.nan
    grid = build_grid([build_clock(time, "log")], None, "log")
    measured = resample(series("angle", time, values), grid)
    assert np.isnan(measured).sum() == (lost if lost + 1 > GAP_PERIODS else 0)
    assert np.isfinite(measured[[39, 40 + lost]]).all()
    held = resample(series("voltage", time, values), grid)
    assert held[40 : 40 + lost] == pytest.approx([3.0 * 0.39] * lost)


def test_a_slow_channel_among_fast_ones_has_no_gaps(tmp_path: Path) -> None:
    time = ticks(0.01, 301)
    slow = np.where(np.arange(301) % 10 == 0, 2.0 * time, np.nan)
    log = read_log(rig(tmp_path, time, position=slow))
    assert log["position"].values == pytest.approx(2.0 * time)
    assert json.loads(log.attrs["log_columns"])["position"]["gaps"] == 0


def test_nothing_is_known_before_the_first_and_after_the_last_sample() -> None:
    long, short = ticks(0.01, 100), ticks(0.01, 60, 20)
    grid = build_grid([build_clock(long, "log"), build_clock(short, "log")], None, "log")
    measured, held = (resample(series(name, short, short), grid) for name in ("force", "voltage"))
    assert np.isnan(measured[:20]).all()
    assert np.isnan(measured[80:]).all()
    assert np.isnan(held[:20]).all()
    assert np.all(held[80:] == short[-1])


def rig(folder: Path, time: Array, **more: Array) -> Path:
    wave = np.sin(ticks(3.0, time.size) / 20.0) + 0.001 * np.random.default_rng(1).normal(size=time.size)
    return write_csv(folder / "rig.csv", {"time": time, "force": wave, **more})


def clock_told(folder: Path, time: Array) -> tuple[dict[str, object], list[str]]:
    log = read_log(rig(folder, time))
    issues = find_issues(log)
    return json.loads(log.attrs["log_clocks"])[0], [f"{f.severity}: {f.text}" for f in issues if "force" in f.channel]


def test_of_doubled_stamps_the_last_sample_is_used_and_it_is_told(tmp_path: Path) -> None:
    time = ticks(0.01, 300)
    time[[50, 120]] = time[[51, 121]]
    told, issues = clock_told(tmp_path, time)
    assert told["duplicates"] == 2
    assert issues == ["note: 2 samples with the stamp of the next one; the last of each is used"]
    coarse, issues = clock_told(tmp_path, np.floor(ticks(0.01, 300) / 0.02) * 0.02)
    assert coarse["duplicates"] == 150
    assert issues[0].startswith("warning: 150 samples with the stamp of the next one")


def test_one_reset_of_the_clock_is_cut_and_told(tmp_path: Path) -> None:
    time = np.append(ticks(0.01, 100), ticks(0.01, 250))
    told, issues = clock_told(tmp_path, time)
    assert told["cut"] == 100
    assert issues == ["warning: the clock jumps back from 0.99 s to 0 s at sample 101; 100 samples are cut"]


def test_time_that_goes_backwards_more_than_once_is_refused(tmp_path: Path) -> None:
    time = ticks(0.01, 100)
    time[[20, 70]] -= 0.05
    with pytest.raises(InputError, match=r"time goes backwards 2 times, first from 0.19 s to 0.15 s at sample 21"):
        read_log(rig(tmp_path, time))


def test_jitter_and_gaps_are_told(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    time = np.sort(0.01 * (ticks(1.0, 300) + rng.uniform(-0.45, 0.45, 300)))
    time[150:] += 0.5
    told, issues = clock_told(tmp_path, time)
    assert told["jitter"] == pytest.approx(np.std(rng.uniform(-0.45, 0.45, 100000) * np.sqrt(2)) * 0.01, rel=0.3)
    assert issues[0].startswith("warning: 1 gap, the longest of 0.5")
    assert any(text.startswith("note: stamps jitter by 0.00") for text in issues)


def test_a_command_with_a_gap_is_held_and_told(tmp_path: Path) -> None:
    time = ticks(0.01, 300)
    volts = np.where(np.arange(300) % 40 < 20, 4.0, 6.0)
    volts[100:150] = np.nan
    log = read_log(rig(tmp_path, time, voltage=volts))
    assert np.all(log["voltage"].values[100:150] == volts[99])
    notes = [f for f in find_issues(log) if f.channel == "voltage"]
    assert [(f.severity, f.right) for f in notes] == [("note", "the command is held there")]
    assert "1 gap, the longest of 0.51 s from 0.990 s" in notes[0].text


def test_undated_samples_are_left_out(tmp_path: Path) -> None:
    time = ticks(0.01, 300)
    time[10:12] = np.nan
    told, issues = clock_told(tmp_path, time)
    assert told["undated"] == 2
    assert issues == ["note: 2 samples without stamp, first sample 11, left out"]
