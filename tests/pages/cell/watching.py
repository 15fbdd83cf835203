"""`layflat cell pack --watch` in a process of its own, and browsers that look on."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.pages.browsers import Served, link_from

COMMAND = [sys.executable, "-c", "from layflat.cli import main; main()", "cell", "pack", "--watch", "--no-browser"]


class Ended:
    """How the command ended, once it has."""

    status: int
    out: str
    err: str


@contextmanager
def watching(cell: Path, out: Path, *words: str, opengl: bool = True) -> Iterator[tuple[Served, Ended]]:
    """Pack with a page until the block ends, then press Ctrl-C."""
    command = [*COMMAND, "--cell", str(cell), "--out", str(out), "--film", "none", "--port", "0", *words]
    environment = dict(os.environ) if opengl else os.environ | {"MUJOCO_GL": "nothing"}
    pipe, ended = subprocess.PIPE, Ended()
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=environment) as process:
        assert process.stdout is not None
        link = link_from(process.stdout)
        try:
            assert link, process.communicate(timeout=10.0)
            yield Served(process, link), ended
        finally:
            process.send_signal(signal.SIGINT)
            ended.out, ended.err = process.communicate(timeout=60.0)
            ended.status = process.returncode


def until(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    """Wait for something; tests run beside others."""
    begun = time.monotonic()
    while not condition():
        assert time.monotonic() - begun < seconds, condition
        time.sleep(0.05)


def text(page: Any, name: str) -> str:
    """The text of an element by its id."""
    return str(page.locator(f"#cell-{name}").inner_text())


def picks(page: Any) -> int:
    """How many picks a page says were done; none before it was shown anything."""
    number, *_ = text(page, "picks").split()
    return int(number) if number != "-" else 0


def width(page: Any, name: str) -> int:
    """How many pixels wide the image is that a page shows, 0 where there is none."""
    return int(page.evaluate(f"document.getElementById('cell-{name}')?.naturalWidth ?? 0"))


def serious(page: Any) -> list[tuple[str, str]]:
    """What an accessibility check finds."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    found = axe.run(page).response["violations"]
    return [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in {"serious", "critical"}]


def results(out: Path) -> dict[str, Any]:
    """What a command wrote in a folder."""
    found: dict[str, Any] = json.loads((out / "results.json").read_text(encoding="utf-8"))
    return found
