"""Completion in a shell, by the protocol of the script that `layflat completion` prints."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from layflat.cell.file.loader import CELL_LIBRARY
from layflat.cli.completers import BUILTIN_FOLDERS, complete_name
from layflat.design.arm import TASK_LIBRARY
from layflat.machine.loader import BENCH_LIBRARY, MACHINE_LIBRARY
from layflat.motion.file import MOTION_LIBRARY
from layflat.study.study import STUDY_LIBRARY
from tests.cli.commands import LAYFLAT, layflat, refused

LIBRARIES = {
    "machine": MACHINE_LIBRARY,
    "bench": BENCH_LIBRARY,
    "task": TASK_LIBRARY,
    "study": STUDY_LIBRARY,
    "motion": MOTION_LIBRARY,
    "cell": CELL_LIBRARY,
}
REPORT_MODULES = "import sys, atexit; atexit.register(lambda: print(*sys.modules, file=sys.stderr))\n"
HEAVY = {"numba", "llvmlite", "scipy", "matplotlib"}


def completed(line: str, folder: Path, shell: str = "bash") -> list[str]:
    """Return what a shell is offered for the last word of a line."""
    words = ["layflat", *line.split(" ")]
    variables = {
        "COMP_WORDS": "\n".join(words),
        "COMP_CWORD": str(len(words) - 1),
        "_TYPER_COMPLETE_ARGS": " ".join(words),
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "_LAYFLAT_COMPLETE": f"complete_{shell}",
    }
    code = f"{REPORT_MODULES}from layflat.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True, text=True, check=False, cwd=folder, env=os.environ | variables, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not HEAVY & set(done.stderr.split())
    return list(filter(None, done.stdout.splitlines()))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("mach", ["machine"]),
        ("machine ", ["list", "show", "check", "schema"]),
        ("simulate paper-arm-f", ["paper-arm-fast", "paper-arm-fast-tuned"]),
        ("simulate mi", ["mine.toml"]),
        ("machine show fric", ["friction-rig"]),
        ("simulate friction", []),
        ("joint sweep paper-arm --joint ", ["large", "small"]),
        ("joint sweep mine.toml --joint ", ["large", "small"]),
        ("joint sweep nowhere.toml --joint ", []),
        ("study run val", ["valves"]),
        ("study show val", ["valves"]),
        ("motion plan to", ["tour"]),
        ("motion plan tour picking", ["picking-arm"]),
        ("cell pack --cell ", ["belt", "packing", "mine.toml"]),
        ("cell show ", ["belt", "packing"]),
        ("arm size pick", ["picking-arm"]),
        ("identify log.csv --machine reg", ["regulated-elbow"]),
        ("tune paper-arm --from ", ["neutral", "current"]),
        ("rig run paper-arm --driver sim", ["simulated"]),
        ("docs tutorials/pack", ["tutorials/pack-produce"]),
        ("completion ", ["bash", "zsh", "fish"]),
        ("simulate paper-arm --dem", ["--demand"]),
        ("simulate paper-arm --demand ", []),
    ],
)
def test_a_word_is_completed(line: str, expected: list[str], tmp_path: Path) -> None:
    """Without an offer a shell completes names of files."""
    (tmp_path / "mine.toml").write_text('extends = "paper-arm"\n', encoding="utf-8")
    (tmp_path / "data.csv").touch()
    assert completed(line, tmp_path) == expected


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_are_offered_the_same(shell: str, tmp_path: Path) -> None:
    offered = completed("simulate paper-arm-f", tmp_path, shell)
    assert [word for word in ("paper-arm-fast", "paper-arm-fast-tuned") if word not in "\n".join(offered)] == []
    assert any("Simulate a machine with its controller." in line for line in completed("simul", tmp_path, shell))


@pytest.mark.parametrize("noun", BUILTIN_FOLDERS)
def test_names_are_those_of_the_libraries(noun: str) -> None:
    assert tuple(complete_name(noun, files=False)("")) == LIBRARIES[noun].names


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_is_one_that_the_shell_takes(shell: str, tmp_path: Path) -> None:
    script = tmp_path / "script"
    script.write_text(layflat("completion", shell).stdout, encoding="utf-8")
    assert f"_LAYFLAT_COMPLETE=complete_{shell}" in script.read_text(encoding="utf-8")
    if shutil.which(shell):
        subprocess.run([shell, "-n", str(script)], check=True)


def test_bash_completes_by_the_script(tmp_path: Path) -> None:
    program = tmp_path / "layflat"
    program.write_text(f"#!/bin/sh\nexec {LAYFLAT[0]} -c '{LAYFLAT[2]}' \"$@\"\n", encoding="utf-8")
    program.chmod(0o755)
    script = layflat("completion", "bash").stdout
    ask = 'COMP_WORDS=(layflat arm size p); COMP_CWORD=3; _layflat_completion "$0"; echo "${COMPREPLY[@]}"'
    done = subprocess.run(
        ["bash", "-c", f"{script}\n{ask}", str(program)], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout == "picking-arm\n"


def test_another_shell_is_one_line() -> None:
    assert refused("completion", "csh") == "layflat: SHELL: unknown shell 'csh'; give bash, zsh or fish"
