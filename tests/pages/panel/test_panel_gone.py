"""The rig goes, and comes back; then the server is killed: the page says so, and the rig makes itself safe."""

import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from layflat.rig.session import STARTS_WITHIN
from tests.cli.served_rig import LAYFLAT, ServedRig
from tests.pages.browsers import PATIENT_ARM, Served, chromium, link_from
from tests.pages.panel.driving import pressed, ready, state, until


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture
def server(rig: ServedRig, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    pytest.importorskip("nicegui")
    command = [*LAYFLAT, "panel", "arm.toml", "--driver", rig.address, "--port", "0", "--no-browser"]
    made = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    yield made
    made.kill()
    made.communicate()


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[ServedRig]:
    (tmp_path / "arm.toml").write_text(PATIENT_ARM, encoding="utf-8")
    made = ServedRig("arm.toml", "--modbus", "0", cwd=tmp_path)
    yield made
    made.end(signal.SIGKILL)


def test_a_rig_and_a_server_that_go_away_are_told_and_the_rig_is_safe(
    rig: ServedRig, server: subprocess.Popen[str], tmp_path: Path, browser: Any
) -> None:
    assert server.stdout is not None
    page = Served(server, link_from(server.stdout)).page(browser)
    until(lambda: is_reset(page), STARTS_WITHIN)
    port = rig.address.rpartition(":")[2]
    assert rig.end() == 0
    until(lambda: "Link lost" in page.inner_text("main"), 60.0)
    other = ServedRig("arm.toml", "--modbus", port, cwd=tmp_path)
    try:
        until(lambda: is_reset(page), 60.0)
        ready(page)
        server.kill()
        until(lambda: "Connection lost" in page.inner_text("body"), 60.0)
        assert other.vented()
        assert "supply 0.00 bar" in other.ask("state")
    finally:
        other.end(signal.SIGKILL)


def is_reset(page: Any) -> bool:
    pressed(page, "Reset")
    return state(page) == "Off"
