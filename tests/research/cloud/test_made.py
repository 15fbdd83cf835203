"""A cloud's file says of each member what the walk found."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.experiments.bench import load_bench
from layflat.machine import load
from research.calibration.unknowns import values_in
from research.cloud.made import write
from research.cloud.open import ALONE, ARM, BLOCKS, GROUPS, built_in_shares, excluded_values, values


@pytest.fixture(scope="module")
def shares() -> np.ndarray:
    rng = np.random.default_rng(4)
    return np.clip(built_in_shares() + 0.2 * rng.standard_normal((3, len(built_in_shares()))), 0.0, 1.0)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, shares: np.ndarray) -> Path:
    path = tmp_path_factory.mktemp("cloud") / "some.cloud.json"
    write(path, list(shares), "make it")
    return path


def test_every_unknown_has_a_place_of_its_own() -> None:
    columns = [i for block in BLOCKS for i in range(block.columns.start, block.columns.stop)]
    assert columns == list(range(sum(len(group.unknowns) for group in GROUPS)))


def test_a_range_that_leaves_out_the_built_in_value_is_told() -> None:
    assert excluded_values() == []
    group = replace(GROUPS[0], unknowns=(replace(GROUPS[0].unknowns[0], low=0.5),))
    (line,) = excluded_values([group])
    own = 1e8 * float(value_at(load("paper-arm"), "valve.conductance"))
    assert line == (
        f"paper-arm: valve.conductance: the built-in value, {own:.3g} dm^3/(s bar), "
        "lies outside 0.5 to 2.5 dm^3/(s bar)"
    )


@pytest.mark.parametrize("number", [0, 2])
def test_a_member_is_what_was_judged(file: Path, shares: np.ndarray, number: int) -> None:
    on = load_bench(f"paper-arm@{file}:{number}")
    judged = ((on.arm, ARM), (on.axis_one, ALONE), (on.earlier, ALONE))
    for machine, part in judged:
        found = values_in(machine, values(shares[[number]], part))
        assert len(found) > 40
        for path, value in found.items():
            assert value_at(machine, path) == pytest.approx(value[0], rel=1e-5), path


def test_members_differ_and_the_built_in_machine_stays(file: Path) -> None:
    before = load("paper-arm")
    one, other = (load(f"paper-arm@{file}:{number}") for number in (0, 1))
    assert one.valve != other.valve
    assert load("paper-arm") == before
