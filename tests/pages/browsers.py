"""A real browser without a screen, and commands that serve pages, for tests."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import pytest

from tests.pages.server.serving import lines_of
from tests.programs import skip_without

ARGUMENTS = ["--no-sandbox"]  # tests may run as root
# Where the time until a lease lapses isn't what is tested: a browser that draws by software, beside the rest on two
# cores, may pause for seconds, and a rig that is rightly held again and again gets nowhere.
PATIENT = """
from layflat.pages.panel import operators
from layflat.rig import session
session.HELD_AFTER, session.STALE_AFTER, operators.MAX_BEAT_AGE, operators.MAX_BEATS = 8.0, 9.0, 8.0, 640
"""
# A cycle and a reply may take long, too, where the computer itself is one of several on the same processors.
PATIENT_ARM = """
extends = "paper-arm-tracking"
name = "arm-with-tool"
[interface]
outputs = ["gripper"]
watchdog_cycles = 40
dump_after = "0.4 s"
[interface.modbus]
timeout = "60 ms"
"""
PATIENT_HOST = """
[safety]
setpoint_age = "1 s"
"""
HARMLESS = ("GPU stall", "GL Driver Message")  # what a browser without a device says of its speed


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser; the test is skipped where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api")
    if shutil.which("chromium") is None:
        skip_without("chromium")
    with sync_api.sync_playwright() as playwright, launched(playwright.chromium) as browser:
        yield browser


@contextmanager
def launched(kind: Any) -> Iterator[Any]:
    """One more browser of this kind."""
    browser = kind.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
    try:
        yield browser
    finally:
        browser.close()


def kill_pages(browser: Any) -> float:
    """End the processes of a browser's pages, at once; returns when, s since 1970."""
    processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    begun = time.time()  # to ask for the processes takes a while, in which the pages still live
    for process in processes:
        if process["type"] == "renderer":
            os.kill(process["id"], signal.SIGKILL)
    return begun


@dataclass
class Served:
    """A command that serves a page."""

    process: subprocess.Popen[str]
    link: str
    complaints: list[str] = field(default_factory=list)  # of browsers' consoles

    def page(self, browser: Any, width: int = 1280, height: int = 800) -> Any:
        """A page of a browser of its own, as by the start link."""
        page = browser.new_context(viewport={"width": width, "height": height}).new_page()
        page.set_default_timeout(15000.0)
        page.on("console", self._hear)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.goto(self.link)
        page.wait_for_selector("main")
        return page

    def _hear(self, message: Any) -> None:
        if message.type in {"error", "warning"} and not any(words in message.text for words in HARMLESS):
            self.complaints.append(message.text)


def link_from(lines: IO[str]) -> str:
    """The link that a command prints, alone on a line; empty where none comes."""
    return next((line.strip() for line in lines if re.fullmatch(r"https?://\S+\n", line)), "")


@contextmanager
def served(folder: Path, *words: str, before: str = "") -> Iterator[Served]:
    """A `layflat` command that serves a page, in a folder, until the end; then it stops as by Ctrl-C."""
    program = f"{before}\nfrom layflat.cli import main\nmain()"
    command = [sys.executable, "-c", program, *words, "--port", "0", "--no-browser"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=folder, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        link = link_from(process.stdout)
        assert link, process.stderr.read()
        try:
            yield Served(process, link)
        finally:
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=60.0)
    assert process.returncode == 0, said
    assert not lines_of(said), said
