"""The command of the panel refuses what it can't open, reach or serve in one line."""

import socket
from pathlib import Path

import pytest

from tests.cli.commands import refused


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["paper-arn"], "paper-arn: no such machine; did you mean 'paper-arm'?"),
        (["paper-arm", "--driver", "nowhere"], "nowhere: is not a driver's address"),
        (["paper-arm", "--host", "192.0.2.1"], "--host: '192.0.2.1' can be reached from other computers"),
        (["paper-arm", "--certificate", "none.pem"], "--key: is missing"),
    ],
)
def test_wrong_options_are_one_line(words: list[str], expected: str, tmp_path: Path) -> None:
    pytest.importorskip("nicegui")
    line = refused("panel", *words, "--no-browser", cwd=tmp_path)
    assert expected in line


def test_a_port_in_use_is_named_and_the_rig_is_let_go_of(tmp_path: Path) -> None:
    pytest.importorskip("nicegui")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = refused("panel", "paper-arm", "--port", str(port), "--no-browser", cwd=tmp_path)
    assert line.startswith(f"layflat: --port: port {port} can't be had")
