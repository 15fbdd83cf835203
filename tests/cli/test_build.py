"""The command `build`: its mistakes are lines, and cost nothing."""

from pathlib import Path

import pytest

from tests.cli.commands import layflat


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("build", "paper-small-joint", "--pose", "sideways"), "--pose: unknown pose 'sideways'; give mid, low, high"),
        (("build", "paper-smal-joint"), "paper-smal-joint"),
        (("build", "paper-small-joint", "--prices", "missing.toml"), "missing.toml"),
        (("build", "rig-shell-steel"), "no joint has solids"),
    ],
)
def test_mistakes_are_one_line(words: tuple[str, ...], text: str, tmp_path: Path) -> None:
    done = layflat(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert text in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
