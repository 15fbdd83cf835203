"""A run with a page that ends by itself, and one that Ctrl-C ends; without images, which take time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.pages.browsers import chromium
from tests.pages.cell.watching import results, serious, text, until, watching

pytest.importorskip("mujoco")
pytest.importorskip("nicegui")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


def test_without_images_the_rest_is_shown(few: Path, tmp_path: Path, browser: Any) -> None:
    with watching(few, tmp_path / "out", "--picks", "1", opengl=False) as (served, ended):
        page = served.page(browser)
        until(lambda: "The run has ended: 1 of 1 picks." in text(page, "end"), 120.0)
        assert "1 of 1 pick correct" in text(page, "end")
        assert "No image can be rendered" in text(page, "no-images")
        assert not page.locator("#cell-overview").is_visible()
        assert serious(page) == []
        assert not served.complaints
        page.context.close()
    assert ended.status == 0
    assert "the run has ended; the page stays until Ctrl-C" in ended.out
    assert results(tmp_path / "out")["runs"][0]["perception"] == "scene"


def test_ctrl_c_ends_the_run_and_the_page(few: Path, tmp_path: Path) -> None:
    with watching(few, tmp_path / "out", "--picks", "40", opengl=False) as (served, ended):
        pass
    assert served.process.returncode == ended.status == 130
    assert ended.err.splitlines()[-1].startswith("layflat: stopped ")
