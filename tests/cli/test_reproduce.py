"""`layflat reproduce`: exit status, machines that lack parts, and results of a part."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.commands import layflat


def test_reproduce_leaves_with_1_when_a_claim_does_not_agree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("layflat.experiments.axis_one.SEED_COUNT", 1)
    text = 'extends = "paper-arm"\nname = "weak"\n[joint.small.hose]\nwidth = "100 mm"\n'
    (tmp_path / "weak.toml").write_text(text, encoding="utf-8")
    done = layflat("reproduce", "--machine", "weak.toml", "--out", "out", cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    claims = {
        claim["id"]: claim for claim in json.loads((tmp_path / "out" / "claims.json").read_text(encoding="utf-8"))
    }
    assert claims["small-joint-torque"]["agrees"] is False
    assert claims["table-1"]["agrees"] is True
    assert (tmp_path / "out" / "report.html").exists()


def test_reproduce_evaluates_a_machine_of_one_joint_by_what_it_has(tmp_path: Path) -> None:
    done = layflat("reproduce", "--machine", "paper-small-joint", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "12 of 12 claims agree; 8 do not apply to this machine" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    assert "open-loop-hysteresis" in done.stdout
    claims = json.loads((tmp_path / "out" / "claims.json").read_text(encoding="utf-8"))
    (coupling,) = (claim for claim in claims if claim["id"] == "coupling")
    assert coupling["agrees"] is None
    assert coupling["reason"] == "not applicable: paper-small-joint: has no joint 'large'"


STOPPED = """
import sys
from layflat.experiments.two_axis import TwoAxisExperiment

def stopped(_):
    raise KeyboardInterrupt

TwoAxisExperiment.steps = property(stopped)
sys.argv = ["layflat", "reproduce", "--out", "out"]
from layflat.cli import main
main()
"""


def test_a_stopped_reproduction_keeps_what_was_evaluated(tmp_path: Path) -> None:
    words = [sys.executable, "-c", STOPPED]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False, timeout=300)
    assert done.returncode == 130, done.stderr
    assert done.stderr.splitlines() == ["layflat: stopped after 6 of 20 claims; partial results are in out"]
    assert "6 of 6 claims agree; partial: stopped before 14 were evaluated" in done.stdout
    claims = json.loads((tmp_path / "out" / "claims.json").read_text(encoding="utf-8"))
    agrees = [claim["agrees"] for claim in claims]
    assert (len(agrees), agrees.count(True), agrees.count(None)) == (20, 6, 14)
    assert "partial: stopped" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
