"""The page of a run in a real browser, beside the run."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.commands import layflat
from tests.pages.browsers import chromium
from tests.pages.cell.watching import picks, results, serious, text, until, watching, width

pytest.importorskip("mujoco")
pytest.importorskip("nicegui")
MANY = 200  # picks, of which only some are done


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


def cut_off(page: Any) -> bool:
    return bool(page.evaluate("document.documentElement.scrollWidth > window.innerWidth"))


def alone(cell: Path, out: Path, *words: str) -> dict[str, Any]:
    """The results of a run without a page."""
    done = layflat("cell", "pack", "--cell", str(cell), "--out", str(out), "--film", "none", *words)
    assert done.returncode == 0, done.stderr
    return results(out)


@pytest.mark.usefixtures("opengl")
def test_a_run_is_seen_by_several_and_stopped_by_one(few: Path, tmp_path: Path, browser: Any) -> None:
    expected, out = alone(few, tmp_path / "alone", "--picks", "3"), tmp_path / "out"
    calibration = str(tmp_path / "alone" / "calibration.toml")
    with watching(few, out, "--picks", f"{MANY}", "--calibration", calibration) as (served, ended):
        page = served.page(browser)
        until(lambda: width(page, "overview") == 720)
        until(lambda: width(page, "camera") == 1280)
        until(lambda: "The arm" in text(page, "doing"))
        assert text(page, "status").startswith("A simulation")
        assert text(page, "seen") == "Seen: tomato 2"
        page.get_by_role("button", name="as fast as it computes").click()
        until(lambda: picks(page) >= 1)
        assert serious(page) == []

        late = served.page(browser, 820, 1180)
        assert late.get_by_role("button", name="as fast as it computes").get_attribute("aria-pressed") == "true"
        until(lambda: picks(late) >= 3)
        until(lambda: width(late, "camera") == 1280)
        assert late.locator("#cell-picks-table tbody tr:visible").count() >= 3
        assert not any(cut_off(one) for one in (page, late))

        late.get_by_role("button", name="Stop").click()
        late.get_by_role("button", name="Cancel").click()
        late.get_by_role("button", name="Stop").click()
        late.get_by_role("button", name="End the run").click()
        until(lambda: "The run has ended early: stopped after" in text(page, "end"))
        done = picks(page)
        page.reload()
        page.wait_for_selector("#cell-end")
        until(lambda: width(page, "camera") == 1280)
        for one in (page, late):
            assert f"wrote {out / 'results.json'}" in text(one, "end")
            assert picks(one) == done
            assert not one.get_by_role("button", name="Stop").is_enabled()
            assert not served.complaints
            one.context.close()
    assert ended.status == 130
    assert ended.err.splitlines()[-1].startswith(f"layflat: stopped after {done} of {MANY} picks; partial results are")
    kept = results(out)
    assert kept["partial"] is True
    assert kept["summary"]["picks"] == done
    first, as_expected = (of["runs"][0]["deliveries"][0] for of in (kept, expected))
    assert first == as_expected, "a delivery that is over is what it is without a page"
