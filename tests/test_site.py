"""The documentation is built as a site without a warning, has every page, and can be searched."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest

from tests.pages.browsers import chromium

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    folder = tmp_path_factory.mktemp("site") / "html"
    command = [sys.executable, "-m", "docs.site", str(folder), "--no-run"]  # tests/test_examples.py runs the examples
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def test_every_page_is_there(site: Path) -> None:
    pages = [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    missing = [page for page in pages if not (site / page.relative_to(ROOT)).with_suffix(".html").exists()]
    assert missing == []


def test_keys_commands_and_names_are_listed(site: Path) -> None:
    keys = (site / "reference/descriptions.html").read_text(encoding="utf-8")
    assert "joint.NAME.hose" in keys
    assert "width of the flat hose" in keys
    assert "layflat rig faults" in (site / "reference/commands.html").read_text(encoding="utf-8")
    assert "layflat.design.size_joint" in (site / "reference/interface.html").read_text(encoding="utf-8")


def test_every_example_has_a_page(site: Path) -> None:
    examples = sorted((ROOT / "examples").rglob("*.py"))
    pages = [site / "gallery" / path.relative_to(ROOT / "examples").with_suffix(".html") for path in examples]
    assert [page for page in pages if not page.exists()] == []
    assert (site / "gallery" / "index.html").read_text(encoding="utf-8").count("sphx-glr-thumbcontainer") >= len(
        examples
    )
    for path in examples:
        assert list(site.glob(f"_downloads/*/{path.stem}.ipynb")), path


def test_it_can_be_searched(site: Path) -> None:
    assert "hysteresi" in (site / "searchindex.js").read_text(encoding="utf-8")


def test_nothing_is_fetched(site: Path) -> None:
    """Pages open without a network: scripts, styles and pictures lie beside them."""
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for start in ('<script src="', '<link rel="stylesheet" type="text/css" href="', '<img src="'):
            assert f"{start}http" not in text, page


class QuietHandler(SimpleHTTPRequestHandler):
    """Files of a folder, without a word on the terminal."""

    def log_message(self, *_: object) -> None: ...


@contextmanager
def served_folder(folder: Path) -> Iterator[str]:
    """The address at which a folder is served."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=str(folder))) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_a_browser_finds_pages_that_all_people_can_use(site: Path) -> None:
    """Search answers, and neither colours nor markup shut anyone out, in light and in dark."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    with chromium() as browser, served_folder(site) as address:
        page = browser.new_page()
        page.goto(f"{address}search.html?q=hysteresis")
        page.locator("#search-results a", has_text="Losses in hose and strap").first.wait_for()  # they come one by one
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            for name in ("index", "gallery/index", "gallery/simulate/valve", "reference/interface"):
                page.goto(f"{address}{name}.html")
                found = axe.run(page).response["violations"]
                assert [one["id"] for one in found if one["impact"] in {"serious", "critical"}] == [], (scheme, name)
