"""Run commands as a person does, in this process: what they print, and the status with which they leave."""

import contextlib
import io
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

from layflat.cli import main

LAYFLAT = [sys.executable, "-c", "from layflat.cli import main; main()"]
"""A command in a process of its own, where its start or its end is what is tested."""


def layflat(*words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command by the program's own entry point, with its handling of errors."""
    out, err, status = io.StringIO(), io.StringIO(), 0
    with (
        contextlib.chdir(cwd or Path.cwd()),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        patch.object(sys, "argv", ["layflat", *words]),
    ):
        try:
            main()
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 1
    return subprocess.CompletedProcess(["layflat", *words], status, out.getvalue(), err.getvalue())


def refused(*words: str, cwd: Path | None = None) -> str:
    """The one line that a refused command leaves on stderr."""
    done = layflat(*words, cwd=cwd)
    assert done.returncode == 2, done
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("layflat: ")
    return lines[0]
