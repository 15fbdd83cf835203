"""The studio in a real browser: a value is changed, seen, saved, undone, refused, by hand and by keyboard alone."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from layflat.machine import load
from tests.cli.commands import layflat
from tests.pages.browsers import Served, chromium, served

pytestmark = pytest.mark.compiled
WIDTH = "Joint large, hose, Width in mm"
ENOUGH = 60.0  # s; what a page takes when nobody else works on the computer is in docs, tests run beside others


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="module")
def studio(folder: Path) -> Iterator[Served]:
    pytest.importorskip("nicegui")
    (folder / "mine.toml").write_text('extends = "paper-arm"\nname = "mine"\n[arm]\npayload = "2 kg"\n')
    with served(folder, "studio", "mine.toml") as found:
        yield found
    assert not found.complaints


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def opened(studio: Served, browser: Any) -> Iterator[Any]:
    page = studio.page(browser)
    until(lambda: current(page), 120.0)  # the first one compiles
    yield page
    page.context.close()


@pytest.fixture
def page(opened: Any) -> Any:
    """The page as it was opened, or with every edit undone."""
    opened.keyboard.press("Escape")  # a test that failed may have left a dialog, which keeps the keys
    undo = opened.get_by_role("button", name="Undo (Ctrl-Z)")

    def undone() -> bool:
        if undo.is_enabled():
            opened.keyboard.press("Control+z")
            time.sleep(0.1)
        return not undo.is_enabled()

    until(undone)
    until(lambda: current(opened))
    return opened


def until(condition: Callable[[], bool], seconds: float = ENOUGH) -> None:
    begun = time.monotonic()
    while not condition():
        assert time.monotonic() - begun < seconds, condition
        time.sleep(0.02)


def current(page: Any) -> bool:
    return bool(page.locator(".st-row").count() and not page.locator(".st-old").count())


def tile(page: Any, name: str) -> float:
    return float(page.locator(".st-tile", has_text=name).locator(".st-value").inner_text())


def field(page: Any, label: str) -> Any:
    return page.get_by_label(label, exact=True)


def enter(page: Any, label: str, value: str) -> None:
    field(page, label).fill(value)
    field(page, label).press("Enter")


def press(page: Any, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def served_solids(page: Any) -> int:
    """Number of files with solids that the page has read."""
    names = "performance.getEntriesByType('resource').filter(one => one.name.includes('/solids/'))"
    return int(page.evaluate(f"() => {names}.length"))


def test_the_arm_is_drawn_by_the_solids_of_its_joints_which_follow_a_change(page: Any) -> None:
    pytest.importorskip("OCP")
    until(lambda: served_solids(page) > 10)
    before = served_solids(page)
    enter(page, WIDTH, "210")
    until(lambda: served_solids(page) > before and current(page))


def test_a_wider_hose_is_seen_saved_and_undone(page: Any, folder: Path) -> None:
    torque, settled = tile(page, "torque"), tile(page, "settled, median")
    enter(page, WIDTH, "200")
    until(lambda: tile(page, "torque") > torque and current(page))
    assert tile(page, "settled, median") != settled
    assert "mine: 1 value changed" in page.inner_text("header")
    press(page, "Save as a description")
    page.get_by_label("Name, below").fill("wide")
    page.keyboard.press("Enter")
    until((folder / "wide.toml").exists)
    assert layflat("machine", "check", str(folder / "wide.toml")).returncode == 0
    assert load(str(folder / "wide.toml")).joint["large"].hose.width == 0.2
    until(lambda: page.locator(".q-dialog").count() == 0)
    press(page, "Save as a description")
    page.get_by_label("Name, below").fill("wide")
    page.keyboard.press("Enter")
    question = page.get_by_text("wide.toml is there already. Write in its place?")
    until(question.is_visible)
    page.get_by_role("button", name="Cancel").last.click()
    until(question.is_hidden)  # it takes the keys until it is gone
    page.get_by_label("Name, below").fill("../wide")
    page.keyboard.press("Enter")
    until(page.get_by_text("'..' can't be a name").is_visible)
    page.keyboard.press("Escape")
    until(lambda: page.locator(".q-dialog").count() == 0)
    field(page, WIDTH).focus()
    page.keyboard.press("Control+z")
    until(lambda: tile(page, "torque") == torque and current(page))
    assert field(page, WIDTH).input_value() == "160"
    page.keyboard.press("Control+Shift+Z")
    until(lambda: tile(page, "torque") > torque)


def test_nonsense_is_refused_in_words(page: Any) -> None:
    enter(page, WIDTH, "banana")
    alert = page.get_by_text("'banana' is not one number with one unit; give a length such as \"160 mm\"")
    until(alert.is_visible)
    page.keyboard.press("Control+z")
    until(lambda: field(page, WIDTH).input_value() == "160")
    assert "as opened" in page.inner_text("header")


def test_everything_can_be_done_by_keyboard(page: Any) -> None:
    torque = tile(page, "torque")
    field(page, "Slider: " + WIDTH).locator(".q-slider__track-container").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    until(lambda: tile(page, "torque") > torque and current(page))
    page.get_by_label("Search values of the description").fill("sonic conductance")
    until(lambda: page.locator(".st-results .st-row").count() == 2)
    page.keyboard.press("Control+a")
    page.keyboard.press("Delete")
    until(lambda: page.locator(".st-results .st-row").count() == 0)
    unnamed = page.evaluate(
        "[...document.querySelectorAll('button, input, [role=slider], [tabindex=\"0\"]')].filter((e) => e.offsetParent"
        " && !(e.ariaLabel || e.innerText || e.labels?.length || e.closest('[aria-label]'))).map((e) => e.outerHTML)"
    )
    assert unnamed == []


def test_a_design_is_compared_with_another(page: Any) -> None:
    press(page, "Keep as A, to compare with")
    enter(page, WIDTH, "200")
    until(lambda: "% against A" in page.locator(".st-tiles").inner_text() and current(page))
    row = page.locator(".lf-table tr", has_text="torque, greatest").inner_text()
    assert "82.14 N m" in row
    assert "%" in row
    press(page, "Return to A: an edit that can be undone")
    until(lambda: field(page, WIDTH).input_value() == "160")
    press(page, "Drop A: compare no more")
    until(lambda: "% against A" not in page.locator(".st-tiles").inner_text())


def test_a_page_that_is_loaded_again_has_its_design_and_another_has_its_own(page: Any, studio: Served) -> None:
    enter(page, WIDTH, "190")
    until(lambda: "1 value changed" in page.inner_text("header"))
    other = page.context.new_page()
    other.goto(page.url)
    until(lambda: other.locator(".st-row").count() > 0)
    assert field(other, WIDTH).input_value() == "160"
    other.close()
    page.reload()
    until(lambda: page.locator(".st-row").count() > 0)
    assert field(page, WIDTH).input_value() == "190"


def test_a_file_that_changes_meanwhile_is_said(page: Any, folder: Path) -> None:
    before = (folder / "mine.toml").read_text()
    (folder / "mine.toml").write_text(before.replace("2 kg", "3 kg"))
    until(page.get_by_text("mine.toml has changed on the disk since it was opened.").is_visible)
    press(page, "Reload, keep my changes")
    until(page.get_by_text("mine.toml has changed").is_hidden)
    (folder / "mine.toml").write_text(before)
    until(page.get_by_text("mine.toml has changed").is_visible)
    press(page, "Go on without")
    until(page.get_by_text("mine.toml has changed").is_hidden)


@pytest.mark.parametrize("width", [1280, 768])
def test_nothing_is_cut_off(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 1024})
    time.sleep(0.1)
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    for side in (".st-left", ".st-right"):
        assert page.evaluate(f"(e => e.scrollWidth <= e.clientWidth)(document.querySelector('{side}'))")


def test_the_page_passes_an_accessibility_check(page: Any) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    found = axe.run(page).response["violations"]
    assert [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in {"serious", "critical"}] == []
