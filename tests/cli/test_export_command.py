"""The command that exports a machine's laws."""

from pathlib import Path

from layflat.cli.completers import complete_target
from tests.cli.commands import refused


def test_mistakes_name_the_option(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert "--target: 'abacus' is not a target; known are c, " in refused(
        "export", "paper-arm", "--target", "abacus", "--out", str(tmp_path / "new")
    )
    assert "--out: " in refused("export", "paper-arm", "--target", "c", "--out", str(tmp_path))
    assert "--precision: 'half' is not a precision" in refused(
        "export", "paper-arm", "--target", "c", "--precision", "half", "--out", str(tmp_path / "new")
    )
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_the_shell_completes_targets() -> None:
    assert "c" in complete_target("")
    assert complete_target("abacus") == []
