"""Build files of boards."""

import shutil
import subprocess
from pathlib import Path

import pytest

from layflat.export.boards import COMPILER_PACKAGES, EXAMPLE_BOARDS


@pytest.mark.parametrize("target", EXAMPLE_BOARDS)
def test_make_says_which_packages_have_the_compiler(target: str, tmp_path: Path) -> None:
    make, board = shutil.which("make"), EXAMPLE_BOARDS[target]
    assert make is not None
    for name, text in board.texts({"title": "paper-arm", "prefix": "paper_arm", "precision": "double"}):
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = subprocess.run(
        [make], cwd=tmp_path, env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    line = f"{board.compiler} is missing; install Debian's packages {COMPILER_PACKAGES[board.compiler]}, or give"
    assert line in done.stderr
