from pathlib import Path

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import load
from layflat.physics.valves.spool import SpoolValvePart
from layflat.sim.ensemble import ensemble
from layflat.study import read_study, run_study, study_table
from tests.study.studies import SMALL, written

VARIANTS = """
[[variant]]
name = "as it is"

[[variant]]
name = "big valve"
factors = { valve.conductance = 2.0 }

[[variant]]
name = "smooth spool"
set = { valve.friction = 0.0, valve.dither.amplitude = 0.0 }
"""


def refused(folder: Path, variants: str) -> str:
    path = written(folder, SMALL + variants)
    with pytest.raises(InputError) as caught:
        read_study(path)
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(f"{path}: ")


def test_a_variant_is_the_machine_with_what_differs(tmp_path: Path) -> None:
    usual = load("paper-small-joint")
    one, big, smooth = (variant.machine for variant in read_study(written(tmp_path, SMALL + VARIANTS)).variants)
    assert one == usual
    assert isinstance(usual.valve, SpoolValvePart)
    assert value_at(big, "valve.conductance") == pytest.approx(2.0 * usual.valve.conductance)
    assert value_at(big, "valve.friction") == usual.valve.friction
    assert (value_at(smooth, "valve.friction"), value_at(smooth, "valve.dither.amplitude")) == (0.0, 0.0)
    assert value_at(smooth, "valve.dither.frequency") == usual.valve.dither.frequency


def test_a_variant_may_be_another_machine(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('extends = "paper-small-joint"\nname = "mine"\n', encoding="utf-8")
    more = '[[variant]]\nname = "a"\nmachine = "earlier-actuator"\n[[variant]]\nname = "b"\nmachine = "mine.toml"\n'
    study = read_study(written(tmp_path, SMALL.replace('low = "0 N m"', 'low = "1 N m"') + more))
    assert [one.machine.name for one in study.variants] == ["earlier-actuator", "mine"]


def test_every_variant_runs_every_sample(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SMALL + VARIANTS))
    assert study.rows == 3 * 24
    whole = run_study(study, tmp_path / "whole")
    found = study_table(tmp_path / "whole")
    assert list(found["variant"]) == ["as it is"] * 24 + ["big valve"] * 24 + ["smooth spool"] * 24
    assert list(found["sample"]) == list(range(24)) * 3
    row = found.iloc[24 + 13]
    vary = {key: [row[key]] for key in ("joint.small.brake.torque", "scenario.payload")}
    alone = ensemble(study.variants[1].machine, study.scenarios[0], vary, precision=study.precision)
    assert float(alone["air_used"][0]) == row["air_used"]
    parts = run_study(study, tmp_path / "parts", chunk=7, threads=1)
    assert study_table(tmp_path / "parts").equals(found)
    assert parts.name == whole.name


def test_a_changed_variant_is_another_study(tmp_path: Path) -> None:
    one = read_study(written(tmp_path, SMALL + VARIANTS)).canonical()
    same = VARIANTS.replace("2.0", "2").replace("valve.dither.amplitude = 0.0", "valve.dither = { amplitude = 0.0 }")
    assert read_study(written(tmp_path, SMALL + same)).canonical() == one
    assert read_study(written(tmp_path, SMALL + VARIANTS.replace("2.0", "2.1"))).canonical() != one
    assert read_study(written(tmp_path, SMALL + VARIANTS.replace("big", "great"))).canonical() != one


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('name = "as it is"', "", "variant.0.name: is missing; a study has a name"),
        ('name = "as it is"', 'nam = "x"', "variant.0"),
        ("big valve", "as it is", "variant.name: 'as it is' is the name of two; give each its own"),
        ("conductance = 2.0", "conductanse = 2.0", "nearest is 'valve.conductance'"),
        ("conductance = 2.0", "dither = 2.0", "variant.1.factors.valve.dither: is not a number"),
        ("conductance = 2.0", "conductance = -2.0", "variant.1.factors.valve.conductance: -2.0 is not a factor"),
        ("conductance = 2.0", "leakage = 1e6", "variant.1.factors: valve: leakage must be smaller than conductance"),
        ("friction = 0.0", "friction = 2.0", "variant.2.set: valve.friction: 2.0 is out of range"),
        ("friction = 0.0", "frictoin = 0.0", "variant.2.set: valve.frictoin: unknown key; did you mean 'friction'?"),
        ('name = "as it is"', 'name = "as it is"\nmachine = "paper-large-joint"', "variant.1: has the joints small"),
        ('name = "as it is"', 'name = "as it is"\nmachine = "papr-arm"', "no such machine; did you mean 'paper-arm'?"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_variant_is_named_in_one_line(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert old in VARIANTS
    assert expected in refused(tmp_path, VARIANTS.replace(old, new, 1))


def test_what_varies_has_to_be_in_every_variant_and_matter_there(tmp_path: Path) -> None:
    rest = '[[variant]]\nname = "earlier"\nmachine = "earlier-actuator"\n'
    more = '[vary."joint.small.deflecting_roller.friction_fraction"]\nvalues = [0.0, 0.01]\n'
    first = '[[variant]]\nname = "new"\n'
    assert "no number of this name can vary" in refused(tmp_path, more + first + rest)
    study = read_study(
        written(tmp_path, SMALL.replace('machine = "paper-small-joint"', 'machine = "earlier-actuator"') + more)
    )
    assert np.prod([len(one.grid()) for one in study.varied]) == study.samples
