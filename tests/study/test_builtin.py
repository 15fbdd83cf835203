"""The studies that come with layflat."""

import subprocess
import sys
from pathlib import Path

import pytest

from layflat.errors import InputError
from layflat.study import is_finished, read_study, run_study, study_names
from layflat.study.study import STUDY_LIBRARY, check_samples

KILLED = """
import os, signal, sys
from layflat.study import read_study, run_study

def progress(done, total):
    if done >= 6:
        os.kill(os.getpid(), signal.SIGKILL)

run_study(read_study(sys.argv[1]).thinned(2), sys.argv[2], chunk=4, threads=1, progress=progress)
"""


@pytest.mark.parametrize("name", study_names())
def test_all_its_runs_can_be_and_all_that_varies_matters(name: str) -> None:
    study = read_study(name)
    assert study.name == name
    assert study.file.title
    check_samples(study.thinned(4), name)


def test_a_killed_one_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    name = "supply-pressure"
    study = read_study(name).thinned(2)
    undisturbed = run_study(study, tmp_path / "undisturbed", chunk=4)
    words = [sys.executable, "-c", KILLED, name, str(tmp_path / "killed")]
    assert subprocess.run(words, check=False, timeout=300).returncode == -9
    kept = len(list((tmp_path / "killed" / "chunks").iterdir()))
    assert 0 < kept < study.rows / 4
    assert not is_finished(study, tmp_path / "killed", chunk=4)
    again = run_study(study, tmp_path / "killed", chunk=4)
    assert again.read_bytes() == undisturbed.read_bytes()
    assert is_finished(study, tmp_path / "killed", chunk=4)
    assert not is_finished(read_study(name), tmp_path / "killed", chunk=4)


def test_a_thinned_study_spans_the_same_with_fewer_samples() -> None:
    whole = read_study("losses-and-brake")
    thin = whole.thinned(3)
    assert thin.rows == 3**3
    for one, other in zip(thin.varied, whole.varied, strict=True):
        assert (one.low, one.high) == (other.low, other.high)
    assert read_study("dither").thinned(3).samples == 3**3
    assert thin.canonical() != whole.canonical()
    assert whole.thinned(1000).samples == whole.samples
    assert read_study("assumptions").thinned(4).samples == 4 * (2 + len(read_study("assumptions").blocks))


def test_a_built_in_file_can_be_started_from(tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(STUDY_LIBRARY.text("supply-pressure"), encoding="utf-8")
    assert read_study(mine).canonical() == read_study("supply-pressure").canonical()


def test_a_name_that_is_none() -> None:
    with pytest.raises(InputError, match="dihter: no such study; did you mean 'dither'"):
        read_study("dihter")
    with pytest.raises(InputError, match="zebra: no such study; `layflat study list` lists them"):
        read_study("zebra")
