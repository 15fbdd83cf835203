"""The pages of the documentation, from the command line."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.cli.commands import layflat, refused

ROOT = Path(__file__).parents[2]
PAGES = [path.relative_to(ROOT / "docs").with_suffix("").as_posix() for path in (ROOT / "docs").rglob("*.md")]


def test_all_pages_are_listed_with_their_titles() -> None:
    listed = layflat("docs").stdout
    for page in PAGES:
        title = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
        assert any(line.split("│")[0].strip() == page and title in line for line in listed.splitlines()), page


@pytest.mark.parametrize("name", ["panel", "panel.md", "tutorials/pack-produce", "pack-produce"])
def test_a_page_is_printed_as_it_is_written(name: str) -> None:
    (path,) = (ROOT / "docs").rglob(f"{Path(name).stem}.md")
    assert layflat("docs", name).stdout == path.read_text(encoding="utf-8")


def test_a_page_that_is_not_there_is_one_line_with_the_nearest() -> None:
    assert "did you mean 'panel'?" in refused("docs", "pannel")


def test_a_wheel_carries_the_pages(tmp_path: Path) -> None:
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    done = subprocess.run([*build, "--wheel-dir", tmp_path, ROOT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {f"layflat/docs/{page}.md" for page in PAGES} <= set(names)
