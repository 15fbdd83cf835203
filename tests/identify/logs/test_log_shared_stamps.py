"""Clocks that are coarser than the rows, that start anew or are set back, and numbers that are no joint's."""

from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import guess_mapping, read_log
from layflat.identify.logs.clocks import unwrap_counter
from layflat.identify.logs.paired_clocks import find_shared_stamps
from tests.identify.logs.recordings import Array, ticks

COUNT = 1000
TIME = ticks(0.01, COUNT)
DEGREES = 40.0 * np.sin(2.0 * TIME)


def written(folder: Path, header: str, *columns: Array | list[str]) -> Path:
    path = folder / "log.csv"
    rows = zip(*columns, strict=True)
    path.write_text(header + "\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
    return path


def check_spread(path: Path, period: float = 0.01) -> None:
    guess = guess_mapping(path)
    log = read_log(path, guess.mapping)
    assert log.attrs["log_period"] == pytest.approx(period, rel=4e-3)
    assert log.sizes["time"] == COUNT
    assert "rows have a stamp of their own" in guess.notes[""]
    assert f"taken for evenly spaced by {1e3 * period:.0f}" in guess.notes[""]


@pytest.mark.parametrize(
    ("header", "stamps"),
    [
        ("time_s", np.floor(TIME)),
        ("time_s", np.floor(10.0 * TIME + 1e-9) / 10.0),
        ("time_s", np.round(TIME)),
        ("timestamp", 1773480413.0 + np.floor(TIME)),
        ("time", np.floor(TIME)),
        ("Time", np.round((46095.4 + TIME / 86400.0), 5)),
        ("Time", [f"09:26:{53 + int(t) % 7:02d}" for t in TIME[:700]] + [f"09:27:0{int(t) - 7}" for t in TIME[700:]]),
    ],
)
def test_rows_that_share_stamps_are_spread_evenly(tmp_path: Path, header: str, stamps: Array | list[str]) -> None:
    check_spread(written(tmp_path, f"{header},angle_deg", stamps, DEGREES))


@pytest.mark.parametrize("rate", [1500.0, 2000.0, 1333.0, 800.0])
def test_rates_beyond_the_clock_s_digits_are_found(rate: float) -> None:
    stamps = np.floor(np.arange(5000) / rate / 2e-3) * 2.0  # ms, in steps of two
    shared = find_shared_stamps(stamps)
    assert shared is not None
    assert shared.period == pytest.approx(1e3 / rate, rel=1e-3)


def test_a_sample_a_row_with_whole_seconds(tmp_path: Path) -> None:
    rows = ((int(t), name, a) for t, a in zip(TIME, DEGREES, strict=True) for name in ("angle_deg", "valve_V"))
    path = written(tmp_path, "time,signal,value", *(list(map(str, column)) for column in zip(*rows, strict=True)))
    check_spread(path)


@pytest.mark.parametrize(
    "kept",
    [np.r_[:320, 560:1000], np.r_[:150]],  # a gap; two whole seconds
)
def test_rows_that_nothing_places_are_asked_for_and_the_period_works(tmp_path: Path, kept: Array) -> None:
    path = written(tmp_path, "time_s,angle_deg", np.floor(TIME)[kept], DEGREES[kept])
    with pytest.raises(InputError, match=r"rows have a stamp of their own, in steps of 1 s; .* `period=\"5 ms\"`"):
        guess_mapping(path)
    log = read_log(path, guess_mapping(path, period="10 ms").mapping)
    assert log["time"].values == pytest.approx(0.01 * np.arange(kept.size))


def test_a_period_spaces_samples_with_times_of_their_own(tmp_path: Path) -> None:
    rows = ((int(t), "angle_deg", a) for t, a in zip(TIME[:150], DEGREES, strict=False))
    path = written(tmp_path, "time,signal,value", *(list(map(str, column)) for column in zip(*rows, strict=True)))
    with pytest.raises(InputError, match="rows have a stamp of their own"):
        guess_mapping(path)
    log = read_log(path, guess_mapping(path, period="10 ms").mapping)
    assert log["time"].values == pytest.approx(0.01 * np.arange(150))


def test_rows_that_are_written_twice_are_no_samples_between(tmp_path: Path) -> None:
    twice = np.repeat(np.arange(COUNT), 2)
    guess = guess_mapping(written(tmp_path, "time_s,angle_deg", TIME[twice], DEGREES[twice]))
    assert "repeat it or fill its gaps" in guess.notes[""]
    assert guess.mapping.time is not None
    assert guess.mapping.time.period is None


def test_two_rows_of_one_stamp_fill_each_other(tmp_path: Path) -> None:
    twice = np.repeat(np.arange(COUNT), 2)
    angle = ["" if k % 2 else str(DEGREES[i]) for k, i in enumerate(twice)]
    valve = [str(TIME[i]) if k % 2 else "" for k, i in enumerate(twice)]
    path = written(tmp_path, "time_s,angle_deg,valve_V", TIME[twice], angle, valve)
    log = read_log(path, guess_mapping(path).mapping)
    assert log["angle"].values == pytest.approx(np.radians(DEGREES))
    assert log["voltage"].values == pytest.approx(TIME)


def test_a_slow_signal_is_not_taken_for_rows_written_twice(tmp_path: Path) -> None:
    check_spread(written(tmp_path, "time_s,angle_deg", np.floor(TIME), np.round(DEGREES / 8.0)))


@pytest.mark.parametrize("size", [2.0**16, 2.0**24, 2.0**32])
@pytest.mark.parametrize("signed", [False, True])
def test_counters_go_on_with_and_without_sign(tmp_path: Path, size: float, signed: bool) -> None:
    low = -0.5 * size if signed else 0.0
    stamps = (np.floor(0.93 * size) + 1e4 * np.arange(COUNT) - low) % size + low
    unwrapped, anew = unwrap_counter(stamps)
    assert np.diff(unwrapped) == pytest.approx(np.full(COUNT - 1, 1e4))
    guess = guess_mapping(written(tmp_path, "timer_us,angle_deg", stamps.astype(int), DEGREES))
    assert f"a counter that starts anew at sample {anew[0]}" in guess.notes[""] if anew else True
    log = read_log(tmp_path / "log.csv", guess.mapping)
    assert log["time"].values == pytest.approx(TIME)


def test_a_clock_that_is_set_back_is_told_with_the_guess(tmp_path: Path) -> None:
    back = guess_mapping(written(tmp_path, "time_s,angle_deg", np.where(TIME > 6.0, TIME - 3.0, TIME), DEGREES))
    assert "set back at sample 602, so that only the samples up to 601 are used" in back.notes[""]
    twice = guess_mapping(written(tmp_path, "time_s,angle_deg", TIME % 3.5, DEGREES))
    assert "goes back 2 times, first at sample 351" in twice.notes[""]


def test_a_coarse_clock_that_is_set_back_is_asked_for(tmp_path: Path) -> None:
    path = written(
        tmp_path, "time_s,angle_deg,valve_V", np.floor(np.where(TIME > 6.0, TIME - 5.0, TIME)), DEGREES, TIME
    )
    with pytest.raises(InputError, match="set back at sample 602; cut the log there, and map each part"):
        guess_mapping(path)


@pytest.mark.parametrize(
    "names",
    [
        ("CH1 Angle [deg]", "CH2 Pressure A [bar]", "CH3 Pressure B [bar]", "CH4 Valve [V]"),
        ("AI0 angle (deg)", "AI1 pA (bar)", "AI2 pB (bar)", "AO0 valve (V)"),
        ("angle_1_deg", "pA_2_bar", "pB_3_bar", "valve_4_V"),
        ("angle1_deg", "pA1_bar", "pB1_bar", "valve_V"),
    ],
)
@pytest.mark.parametrize("joints", [None, ["elbow"]])
def test_numbers_of_columns_are_no_joints(tmp_path: Path, names: tuple[str, ...], joints: list[str] | None) -> None:
    bar = 2.0 + 1.5 * np.sin(TIME)
    path = written(tmp_path, ",".join(["time_s", *names]), TIME, DEGREES, bar, bar, TIME)
    guess = guess_mapping(path, joints)
    assert [entry.channel.partition(".")[0] for entry in guess.mapping.column] == [
        "angle",
        "pressure_a",
        "pressure_b",
        "voltage",
    ]
    assert {entry.joint for entry in guess.mapping.column} == {joints[0] if joints else None}
    assert read_log(path, guess.mapping, joints=joints).sizes["time"] == COUNT


def test_numbers_of_channels_are_no_hoses(tmp_path: Path) -> None:
    path = written(tmp_path, "time_s,angle_deg,CH1 [bar],CH2 [bar]", TIME, DEGREES, 2.0 + TIME, 3.0 + TIME)
    guess = guess_mapping(path)
    assert [entry.signal for entry in guess.mapping.column] == ["angle"]
    assert "may all be pressure" in guess.ignored["CH1 [bar]"]
