"""`layflat log lerobot` as a person uses it."""

import os
import signal
import subprocess
from pathlib import Path

import pytest

from layflat.sim import rollout
from layflat.sim.dataset import save_run
from tests.cli.commands import LAYFLAT, layflat, refused
from tests.lerobot import reading


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run."""
    place = tmp_path_factory.mktemp("runs")
    save_run(rollout("paper-small-joint", [("0 s", "0 deg"), ("0.2 s", "9 deg")], duration="0.6 s"), place / "run.nc")
    return place


def test_runs_become_a_data_set(folder: Path) -> None:
    words = ("log", "lerobot", "run.nc", "run.nc", "--task", "move", "--task", "move again", "--fps", "20")
    done = layflat(*words, "--machine", "paper-small-joint", "--out", "data", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "wrote data: 2 episodes, 26 frames at 20 a second\n"
    assert reading.tasks(folder / "data") == ["move", "move again"]
    assert reading.info(folder / "data")["robot_type"] == "paper-small-joint"
    again = refused(*words, "--out", "data", cwd=folder)
    assert (
        again == "layflat: data: is not empty, it holds 'data'; give a new folder, or --force to replace what it holds"
    )
    forced = layflat("log", "lerobot", "run.nc", "--task", "other", "--out", "data", "--force", cwd=folder)
    assert forced.returncode == 0, forced.stderr
    assert reading.tasks(folder / "data") == ["other"]
    assert {path.name for path in folder.iterdir()} == {"run.nc", "data"}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--fps", "300"), "--fps: 300 frames a second are more than the 200 samples a second of run.nc; give 200 or"),
        (("--fps", "-1"), "--fps: -1 is no number of frames a second; give a whole number from 1 to 1000"),
        (("--action", "torque"), "--action: 'torque' is unknown; give 'demand' or 'voltage'"),
        (("--task", "b", "--task", "c"), "--task: 3 are not as many as 1 logs; give one for all logs, or one for each"),
        (("--machine", "paper-four"), "no such machine"),
    ],
)
def test_mistakes_give_a_line_that_names_the_option(folder: Path, words: tuple[str, ...], said: str) -> None:
    assert said in refused("log", "lerobot", "run.nc", "--task", "a", "--out", "none", *words, cwd=folder)
    assert not (folder / "none").exists()


def test_forcing_does_not_remove_a_folder_of_other_things(folder: Path) -> None:
    words = ("log", "lerobot", "run.nc", "--task", "a", "--out", ".", "--force")
    assert refused(*words, cwd=folder).startswith("layflat: .: is not empty, it holds '")
    assert (folder / "run.nc").exists()


STOPPED = """\
import os, signal
from layflat.lerobot import EpisodeWriter

add = EpisodeWriter.add_episode

def add_and_stop(self, *episode):
    add(self, *episode)
    os.kill(os.getpid(), signal.SIGINT)

EpisodeWriter.add_episode = add_and_stop
"""


def test_ctrl_c_leaves_nothing(folder: Path, tmp_path: Path) -> None:
    command = [
        *LAYFLAT[:2],
        STOPPED + LAYFLAT[2],
        "log",
        "lerobot",
        str(folder / "run.nc"),
        "--task",
        "a",
        "-o",
        "data",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, env=os.environ)
    assert (done.returncode, done.stdout) == (128 + signal.SIGINT, "")
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
