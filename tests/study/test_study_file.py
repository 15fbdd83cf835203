from math import radians
from pathlib import Path

import pytest

from layflat.errors import InputError
from layflat.study import read_study
from tests.study.studies import SMALL, SOBOL, without, written

TORQUE = '[vary."joint.small.brake.torque"]\n'
VARY = without(without(SMALL, 'vary."joint.small.brake.torque"'), 'vary."scenario.payload"')
"""The small study with nothing that varies."""


def refused(folder: Path, text: str) -> str:
    path = written(folder, text)
    with pytest.raises(InputError) as caught:
        read_study(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith((f"{path}: ", "papr-small-joint: "))
    return message.removeprefix(f"{path}: ")


def test_what_a_file_says_is_read_in_si(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SOBOL))
    assert study.samples == 8
    assert study.metrics == ("settling", "air_used")
    payload, brake = sorted(study.varied, key=lambda one: one.path, reverse=True)
    assert payload.values == (0.0, 1.0, 2.0, 3.0)
    assert (brake.low, brake.high, brake.kind.unit) == (0.0, 4.0, "N*m")
    assert study.scenarios[0].demand == [(0.0, radians(-10)), (0.05, radians(10))]
    assert study.scenarios[0].duration == 0.2


def test_the_same_in_other_words_is_the_same_study(tmp_path: Path) -> None:
    one = read_study(written(tmp_path, SMALL))
    text = SMALL.replace('"4 N m"', '"400 N cm"').replace('"0.2 s"', '"200 ms"').replace("[scenario]", "[[scenario]]")
    assert read_study(written(tmp_path, text)).canonical() == one.canonical()
    other = read_study(written(tmp_path, SMALL.replace('"4 N m"', '"4.1 N m"')))
    assert other.canonical() != one.canonical()


def test_a_machine_file_is_meant_relative_to_the_study(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('extends = "paper-small-joint"\nname = "mine"\n', encoding="utf-8")
    assert read_study(written(tmp_path, SMALL.replace("paper-small-joint", "mine.toml"))).machine.name == "mine"


def test_what_varies_takes_the_place_of_a_constant_but_not_of_steps(tmp_path: Path) -> None:
    constant = SMALL.replace("[scenario]", '[scenario]\npayload = "1.5 kg"')
    assert read_study(written(tmp_path, constant)).scenarios[0].payload is None
    later = SMALL.replace("[scenario]", '[scenario]\npayload = [["0.1 s", "1.5 kg"]]')
    assert read_study(written(tmp_path, later)).scenarios[0].payload == [(0.1, 1.5)]
    steps = SMALL.replace("[scenario]", '[scenario]\npayload = [["0 s", "1.5 kg"]]')
    assert "scenario.0.payload: hides scenario.payload, which varies" in refused(tmp_path, steps)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('name = "small"', "", "name: is missing"),
        ('name = "small"', 'name = "small"\nmetric = []', "metric: unknown key; did you mean 'metrics'?"),
        ('name = "small"', 'name = "small', "is not TOML"),
        ('"grid"', '"random"', "sampling: 'random' is not known; give 'grid', 'sobol', 'lhs' or 'saltelli'"),
        ('"grid"', '"sobol"', "runs: is missing; say how many samples, such as 1024"),
        ('"grid"', '"sobol"\nruns = 100', "runs: 100 is not a power of two; Sobol points are balanced in powers of two: give"),  # noqa: E501
        ('"grid"', '"grid"\nnoise_seeds = 0', "noise_seeds: 0 is out of range"),
        ('"air_used"', '"air"', "metrics: 'air' is not a metric; use settling, overshoot"),
        ("duration", "durations", "scenario.0.durations: unknown key; did you mean 'duration'?"),
        ('"0.2 s"', "0.2", 'scenario.0.duration: 0.2 is a bare number; give a time such as "5 ms"'),
        ('"0.2 s"', '"2 kg"', "scenario.0.duration: '2 kg' is not a time"),
        ('"-10 deg"', "-10", 'scenario.0.demand: -10 is a bare number; give an angle such as "120 deg"'),
        ('"-10 deg"', '["1 deg", 2.5]', "scenario.0.demand: 2.5 is a bare number; give an angle"),
        ('"-10 deg"', "{small = 1}", "scenario.0.demand: 1 is a bare number; give an angle"),
        ('"0.05 s"', "0.05", "scenario.0.demand: 0.05 is a bare number; give a time"),
        ('"10 deg"', '"90 deg"', "scenario.0.demand: 90 deg is outside the working stroke of joint 'small'"),
        ("[scenario]", '[scenario]\nstart = "70 deg"', "scenario.0.start: 70 deg is outside the working stroke"),
        ("[scenario]", '[scenario]\npayload = [["0.1 s", "-1 kg"]]', "scenario.0.payload: -1 kg is out of range"),
        ("[scenario]", '[scenario]\nopening = 0.1', "scenario.0.opening: stands beside demand"),
        ("[scenario]", '[scenario]\nnoise = "no"', "scenario.0.noise: 'no' is"),
        ("[scenario]", '[scenario]\nload = [["0.3 s", "1 N m"]]', "scenario.0.load: 0.3 s is after the end"),
        ("[scenario]", '[scenario]\nbrake = 2', "scenario.0.brake: 2 is out of range; give a share from 0 to 1"),
        ('["settling", "air_used"]', "[]", "metrics: is empty; give one or more, or leave it out for all"),
        ("[scenario]", 'step = "1 s"\n[scenario]', "step: 1 s is out of range; give 10 ns to 0.005 s"),
        ("[scenario]", "[[scenario]]\n[[scenario]]", "scenario: are not equally long; give all the same duration"),
        ("paper-small-joint", "papr-small-joint", "papr-small-joint: no such machine; did you mean 'paper-small-joint'?"),  # noqa: E501
        ("[scenario]", '[scenario]\nsupply = ["4 bar"]', "scenario.0.supply: ['4 bar'] is not a pressure"),
        ("[scenario]", '[scenario]\nbrake = "1"', "scenario.0.brake: '1' is not a number; give a number such as 0.5"),
        ('"0 kg", "1 kg"', '"0 kg", "0 g"', "vary.scenario.payload.values: '0 g' is there twice"),
        ('"0 kg", "1 kg"', '"0 kg", "-1 kg"', "vary.scenario.payload.values.1: '-1 kg' is out of range"),
        ('["0 kg", "1 kg", "2 kg", "3 kg"]', "[]", "vary.scenario.payload.values: is empty"),
        ('["0 kg", "1 kg", "2 kg", "3 kg"]', '"1 kg"', "vary.scenario.payload.values: '1 kg' is not a list"),
        ("scenario.payload", "scenario.pay", "no number of this name can vary; nearest is 'scenario.payload'"),
        ("small.brake.torque", "small.break.torque", "nearest is 'joint.small.brake.torque'"),
        ("joint.small.brake.torque", "joint.small.brake", "joint.small.brake: no number of this name can vary"),
        ("joint.small.brake.torque", "zebra", "zebra: no number of this name can vary; `layflat machine show"),
        ('"joint.small.brake.torque"', "joint.small.brake.torque", "vary.joint.small: unknown key; quote the whole path"),  # noqa: E501
        ('high = "4 N m"', "high = 4", 'torque.high: 4 is a bare number; give a torque such as "25 N m"'),
        ('high = "4 N m"', 'high = "4 N"', "torque.high: '4 N' is not a torque"),
        ('high = "4 N m"', 'high = "0 N m"', "torque.low: '0 N m' is not below high, '0 N m'; give less"),
        ('high = "4 N m"', "", "torque.high: is missing; give low and high, mean and std, or values"),
        ('high = "4 N m"', 'hihg = "4 N m"', "vary.joint.small.brake.torque.hihg: unknown key; did you mean 'high'?"),
        ('low = "0 N m"', 'low = "-1 N m"', "torque.low: '-1 N m' is out of range; give at least 0"),
        ('low = "0 N m"', 'low = "0 N m"\nscale = "log"', "torque.low: '0 N m' has no logarithm; give more than zero"),
        ('low = "0 N m"', 'values = ["1 N m"]\nlow = "0 N m"', "torque.high: stands beside values; give one or the other"),  # noqa: E501
        ("points = 6", "", "torque.points: is missing; say how many points the grid has"),
        ("points = 6", "points = 1", "torque.points: 1 is out of range; give at least 2"),
        ('sampling = "grid"', 'precision = "half"', "precision: 'half' is not known; give 'double' or 'single'"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_in_one_line(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert old in SMALL
    assert expected in refused(tmp_path, SMALL.replace(old, new))


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ('"joint.small.brake.torque"]\nmean = "1 N m"', "torque.std: is missing"),
        ('"joint.small.brake.torque"]\nmean = "1 N m"\nstd = "0 N m"', "torque.std: '0 N m' is out of range"),
        ('"joint.small.brake.torque"]\nmean = "1 N m"\nstd = "1 N m"\nlow = "2 N m"', "is not between low and high"),
        ('"joint.small.brake.torque"]\nmean = "1 N m"\nstd = "9 N m"', "is out of range; give at least 0"),
        ('"supply.temperature"]\nmean = "20 degC"\nstd = "5 degC"', "is not a difference of temperatures; give kelvin"),
        ('"angle_sensor.bits"]\nlow = 8\nhigh = 12', "vary.angle_sensor.bits: is a whole number; give values"),
        ('"angle_sensor.bits"]\nvalues = [8, 9.5]', "vary.angle_sensor.bits.values.1: 9.5 is not a whole number"),
        ('"valve.critical_ratio"]\nlow = 0.1\nhigh = 1.5', "vary.valve.critical_ratio.high: 1.5 is out of range"),
        ('"valve.critical_ratio"]\nlow = nan\nhigh = 0.5', "vary.valve.critical_ratio.low: nan is not a finite number"),
        ('"controller.cycle"]\nlow = "5 ms"\nhigh = "9 ms"', "vary.controller.cycle: is the same in all runs"),
        ('"joint.small.body.height"]\nlow = "1 cm"\nhigh = "9 cm"', "body.height: has no effect on a run; leave it out"),  # noqa: E501
        ('"joint.large.brake.torque"]\nlow = "0 N m"\nhigh = "9 N m"', "brake.torque: has no effect on a run"),
        ('"joint.small.losses.weights.0"]\nlow = 0.2\nhigh = 0.5', "weights must add up to 1, for example"),
        ('"joint.small.hose.contact_end"]\nlow = "80 deg"\nhigh = "125 deg"', "contact_end must be smaller than wrap"),
        ('"scenario.supply"]\nlow = "-2 bar"\nhigh = "4 bar"', "vary.scenario.supply.low: '-2 bar' is out of range"),
    ],
)  # fmt: skip
def test_a_mistake_in_what_varies(tmp_path: Path, table: str, expected: str) -> None:
    text = VARY.replace('"grid"', '"lhs"\nruns = 16')
    assert expected in refused(tmp_path, f"{text}\n[vary.{table}\n")


def test_what_is_only_right_together_is_right(tmp_path: Path) -> None:
    alone = '[vary."joint.small.hose.contact_end"]\nvalues = ["125 deg"]\n'
    assert "contact_end must be smaller than wrap" in refused(tmp_path, f"{VARY}\n{alone}")
    together = alone + '[vary."joint.small.hose.wrap"]\nvalues = ["150 deg", "160 deg"]\n'
    assert read_study(written(tmp_path, f"{VARY}\n{together}")).samples == 2


def test_scenarios_need_names_of_their_own(tmp_path: Path) -> None:
    text = SMALL.replace("[scenario]", '[[scenario]]\nname = "same"\n[[scenario]]\nname = "same"')
    assert "scenario.name: two have the same name" in refused(tmp_path, text)


def test_noise_seeds_without_noise(tmp_path: Path) -> None:
    text = SMALL.replace("[scenario]", "noise_seeds = 2\n[scenario]\nnoise = false")
    assert "noise_seeds: has no effect on runs without noise" in refused(tmp_path, text)


def test_single_precision_is_for_short_runs(tmp_path: Path) -> None:
    assert read_study(written(tmp_path)).precision == "single"
    asked = SMALL.replace("[scenario]", 'precision = "double"\n\n[scenario]', 1)
    assert read_study(written(tmp_path, asked)).precision == "double"
    assert read_study(written(tmp_path, asked)).canonical() != read_study(written(tmp_path)).canonical()
    long = SMALL.replace('"0.2 s"', '"61 s"')
    assert read_study(written(tmp_path, long)).precision == "double"
    said = refused(tmp_path, long.replace("[scenario]", 'precision = "single"\n\n[scenario]', 1))
    assert "precision: single is too coarse for runs of 61 s; leave it out, or say double" in said


def test_a_sample_of_nothing(tmp_path: Path) -> None:
    assert read_study(written(tmp_path, VARY)).samples == 1
    text = VARY.replace('"grid"', '"lhs"\nruns = 4')
    assert "vary: nothing varies" in refused(tmp_path, text)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.toml: can't be read \(No such file or directory\)"):
        read_study(tmp_path / "none.toml")


def test_sampling_has_a_default(tmp_path: Path) -> None:
    assert read_study(written(tmp_path, SMALL.replace('sampling = "grid"\n', ""))).file.sampling == "grid"
    assert read_study(written(tmp_path, SOBOL.replace('sampling = "sobol"\n', ""))).file.sampling == "sobol"


@pytest.mark.parametrize("seed", ["-1", "99999999999999999999"])
@pytest.mark.parametrize("place", ["[scenario]", "metrics"])
def test_seeds_out_of_range(tmp_path: Path, seed: str, place: str) -> None:
    text = SMALL.replace(place, f"[scenario]\nseed = {seed}" if place == "[scenario]" else f"seed = {seed}\n{place}", 1)
    with pytest.raises(InputError, match=rf"seed: {seed} is out of range"):
        read_study(written(tmp_path, text))
