"""The command of the studio refuses what it can't open or serve in one line."""

from pathlib import Path

import pytest

from tests.cli.commands import refused


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["paper-arn"], "paper-arn: no such machine; did you mean 'paper-arm'?"),
        (["paper-arm", "--host", "192.0.2.1"], "--host: '192.0.2.1' can be reached from other computers"),
        (["paper-arm", "--key", "none.pem"], "--certificate: is missing"),
    ],
)
def test_wrong_options_are_one_line(words: list[str], expected: str, tmp_path: Path) -> None:
    pytest.importorskip("nicegui")
    line = refused("studio", *words, "--no-browser", cwd=tmp_path)
    assert line.startswith(f"layflat: {expected}")
