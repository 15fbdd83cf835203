"""Studies over the members of a cloud."""

from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine.exchanged import member_names, member_values
from layflat.sim.ensemble import ensemble
from layflat.study import read_study, run_study, study_table
from tests.study.studies import SMALL, written

MEMBERS = "[vary.member]\nvalues = [0, 5, 7]\n"
STUDY = SMALL.partition('[vary."joint')[0] + MEMBERS


def test_each_run_has_the_numbers_of_its_member(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, STUDY))
    run_study(study, tmp_path / "out")
    frame = study_table(tmp_path / "out")
    assert list(frame["member"]) == [0, 5, 7]
    own = {path: numbers[[0, 5, 7]] for path, numbers in member_values("paper-small-joint").items()}
    data = ensemble(study.machine, study.scenarios, own | {"seed": np.zeros(3)}, precision="single")
    assert list(frame["air_used"]) == data["air_used"].to_numpy().tolist()


def test_without_numbers_all_members_are_meant(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, STUDY.replace("values = [0, 5, 7]\n", "")))
    assert study.samples == len(member_names("paper-small-joint"))


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ("values = [99999]", "vary.member.values: 99999 is no member; give numbers from 0 to"),
        ("values = []", "vary.member.values: is empty"),
        ("low = 0\nhigh = 3", "vary.member.high: does not fit members"),
    ],
)
def test_mistakes_are_told(tmp_path: Path, given: str, line: str) -> None:
    with pytest.raises(InputError, match=line):
        read_study(written(tmp_path, STUDY.replace("values = [0, 5, 7]", given)))


def test_what_members_set_does_not_vary_by_itself(tmp_path: Path) -> None:
    twice = STUDY + '[vary."valve.overlap"]\nvalues = [0.01, 0.02]\n'
    with pytest.raises(InputError, match=r"'?valve\.overlap'? varies twice"):
        read_study(written(tmp_path, twice))
