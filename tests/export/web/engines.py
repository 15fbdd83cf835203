"""Node.js, which runs modules in tests."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest


def node() -> str:
    """The program; the test is skipped where there is none."""
    found = shutil.which("node")
    if found is None:
        pytest.skip("needs node")
    return found


def run_script(script: Path, *words: str) -> Any:
    """What a script prints, which is JSON; its error is that of the test."""
    done = subprocess.run([node(), str(script), *words], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def run_text(folder: Path, text: str) -> Any:
    """What a module of text beside others prints; see `run_script`."""
    script = folder / "script.mjs"
    script.write_text(text, encoding="utf-8")
    return run_script(script)
