"""`layflat tune` as a person uses it."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from layflat.machine import load
from tests.cli.commands import LAYFLAT, layflat, refused


def test_gains_a_table_and_a_page(tmp_path: Path) -> None:
    (tmp_path / "any.toml").write_text('extends = "paper-small-joint"\nname = "mine"\n', encoding="utf-8")
    done = layflat("tune", "any.toml", "--generations", "2", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "2 of 2 generations in" in done.stdout
    assert "small joint by 40 deg" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["mine-tuned.toml", "tuning.html"]
    assert layflat("machine", "check", "out/mine-tuned.toml", cwd=tmp_path).returncode == 0


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_an_interrupt_keeps_the_best_so_far(tmp_path: Path) -> None:
    bare = 'extends = "paper-small-joint"\nname = "bare"\nomits = ["joint.small.gains"]\n'
    (tmp_path / "bare.toml").write_text(bare, encoding="utf-8")
    words = [*LAYFLAT, "tune", "bare.toml", "--generations", "5000", "--out", "out"]
    waiting = (
        "import sys; from layflat.tune import tuning as tune; whole = tune.search_knob_values\n"
        "def told(*a, progress, **k):\n"
        "    def tell(best, done, name):\n"
        "        progress(best, done, name); print(done, file=sys.stderr, flush=True)\n"
        "    return whole(*a, progress=tell, **k)\n"
        "tune.search_knob_values = told\n"
    )
    words[2] = waiting + words[2]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.strip() == "2":
                break
        time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=120)
    assert process.returncode == 130, stderr
    assert "layflat: stopped after" in stderr
    assert "Traceback" not in stderr
    assert "partial results are in out" in stderr
    assert "wrote out/bare-tuned.toml" in stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"bare-tuned.toml", "tuning.html"}
    tuned = load(tmp_path / "out" / "bare-tuned.toml")
    assert "stopped after" in tuned.provenance["joint.small.gains.far.error"].note


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["nowhere"], "nowhere: no such machine"),
        (["rig-kevlar"], "rig-kevlar: has no controller to be tuned"),
        (["paper-arm", "--method", "guess"], "--method: unknown method 'guess'"),
        (["paper-arm", "--over", "sky"], "--over: 'sky' is nothing to tune over; give cloud"),
        (["paper-arm", "--generations", "0"], "--generations: 0 is out of range"),
        (["paper-arm", "--out", "/proc/here"], "can't write here"),
    ],
)
def test_a_mistake_gives_one_line(words: list[str], expected: str, tmp_path: Path) -> None:
    assert expected in refused("tune", *words, cwd=tmp_path)
    assert not list(tmp_path.iterdir())


def test_without_its_library_one_line_says_what_to_install(tmp_path: Path) -> None:
    words = [LAYFLAT[0], "-c", f"import sys; sys.modules['cma'] = None; {LAYFLAT[2]}", "tune", "paper-arm"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False, timeout=300)
    assert done.returncode == 2
    assert done.stderr == "layflat: tune: needs cma, not installed; install it: pip install 'layflat[tune]'\n"
