"""The operator's page in a real browser, beside a virtual rig and its loop, in real time."""

import logging
import math
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from layflat.rig.recorder.run import read_run
from layflat.rig.safety.faults import RigState
from layflat.rig.session import STARTS_WITHIN
from tests.pages.browsers import PATIENT, PATIENT_ARM, PATIENT_HOST, Served, chromium, kill_pages, launched, served
from tests.pages.panel.driving import (
    angle,
    drives,
    faulted,
    held,
    inwards,
    jogged,
    onwards,
    press,
    pressed,
    ready,
    state,
    stopped,
    tab,
    until,
    vented,
)

FLOOD = 600  # connections at once; a process may have 1024 files open


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def panel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    pytest.importorskip("nicegui")
    folder = tmp_path_factory.mktemp("panel")
    (folder / "arm.toml").write_text(PATIENT_ARM + PATIENT_HOST, encoding="utf-8")
    with served(folder, "panel", "arm.toml", before=PATIENT) as found:
        yield found
    assert not found.complaints


@pytest.fixture
def page(panel: Served, browser: Any) -> Iterator[Any]:
    """A page that drives, of a rig without air."""
    page = panel.page(browser)
    try:
        until(lambda: drives(page), 30.0)
        until(lambda: vented(page), STARTS_WITHIN)
        yield page
        logging.getLogger(__name__).warning(page.inner_text("body"))  # shown where a test has failed
        until(lambda: vented(page), 30.0)
    finally:
        for context in browser.contexts:  # a page that is left open would go on driving
            context.close()


@pytest.mark.realtime
def test_from_start_to_a_jog_that_ends_when_it_is_released_and_a_stop_in_motion(page: Any) -> None:
    ready(page)
    before = angle(page)
    jogged(page, "large, forwards", lambda: angle(page) > before + 8.0)
    page.mouse.up()
    time.sleep(0.8)
    rest = angle(page)
    time.sleep(0.5)
    assert angle(page) == pytest.approx(rest, abs=0.3)
    tab(page, "Moves")
    for _ in range(2):  # down to the slowest
        page.get_by_role("slider", name="Speed of moves:").locator("[tabindex]").press("PageDown")
    tab(page, "Target")
    page.get_by_label("large (deg)").fill("-50")

    def moves() -> bool:
        tab(page, "Target")
        ready(page)
        pressed(page, "Go to target")
        tab(page, "Jog")
        until(lambda: angle(page) < rest - 3.0 or held(page))
        return not held(page)

    until(moves, 60.0)
    until(lambda: stopped(page))
    time.sleep(0.8)
    there = angle(page)
    assert there > -48.0
    time.sleep(0.5)
    assert angle(page) == pytest.approx(there, abs=0.3)
    ready(page)
    assert angle(page) == pytest.approx(there, abs=0.5), "what was asked for before is forgotten"
    until(lambda: vented(page))
    ready(page)


@pytest.mark.parametrize(
    ("failure", "words", "next_step"),
    [
        ("e-stop", "E-stop", "Release it"),
        ("angle-open", "sensor open or shorted", "wires and plug"),
        ("supply-lost", "Supply lost", "compressor"),
        ("silence", "Link lost", "power, cable and plugs"),
        ("supply-high", "Over-pressure", "regulator"),
        ("burst-hose", "ir does not answer", "hoses and valve"),
    ],
)
def test_a_fault_is_shown_with_what_to_do_and_a_reset_ends_it(
    page: Any, failure: str, words: str, next_step: str
) -> None:
    def told() -> str:
        ready(page)
        tab(page, "Failures")
        page.get_by_role("combobox", name="failure").click()
        page.get_by_role("option", name=failure, exact=True).click()
        press(page, "Fail")
        until(lambda: faulted(page), 30.0)
        found = str(page.locator(".lf-fault").inner_text())
        press(page, "Heal")
        until(over, 60.0)
        return found

    def over() -> bool:
        pressed(page, "Reset")
        return state(page) != "Fault"

    found = told()
    for _ in range(2):  # on a busy computer the device may not answer just then, or the rig be stopped before it fails
        if words not in found:
            found = told()
    assert words in found
    assert next_step in found


def held_and_stopped(folder: Path, browser: Any) -> dict[RigState, float]:
    """How long after a page was killed that was jogging the arm was held, and stopped, by the rig's log, s."""
    (folder / "arm.toml").write_text(PATIENT_ARM, encoding="utf-8")
    with served(folder, "panel", "arm.toml") as panel:
        with launched(browser.browser_type) as another:
            driver = panel.page(another)
            ready(driver)
            before = angle(driver, 1)
            jogged(driver, "small, forwards", lambda: angle(driver, 1) > before + 3.0)
            killed = kill_pages(another)
        page = panel.page(browser)
        until(lambda: state(page) == "Stopped", 60.0)
        page.context.close()
    run = read_run(next(folder.rglob("*-panel.mcap")))
    wall, mode = run["wall"].to_numpy() - killed, run["mode"].to_numpy()
    reached = (RigState.HOLDING, RigState.STOPPED)
    return {one: min(wall[(wall > 0.0) & (mode == one)], default=math.inf) for one in reached}


@pytest.mark.realtime
def test_a_tab_that_is_killed_while_jogging_leaves_an_arm_that_holds_and_stops(tmp_path: Path, browser: Any) -> None:
    for attempt in "abcde":  # a busy computer may take time from loop and server just then
        (folder := tmp_path / attempt).mkdir()
        took = held_and_stopped(folder, browser)
        if took[RigState.HOLDING] < 0.25 and took[RigState.STOPPED] < 1.0:
            return
    raise AssertionError(took)


def pictures(page: Any) -> int:
    """How many times the arm was drawn."""
    scene = page.locator('[aria-label^="The arm in three"]').get_attribute("id")
    return int(page.evaluate(f"getElement({scene[1:]}).renderer.info.render.frame"))


def test_the_arm_is_drawn_only_where_something_changes(page: Any) -> None:
    def still() -> bool:
        before = pictures(page)
        time.sleep(1.0)
        return pictures(page) == before

    until(still, 60.0)
    before = pictures(page)
    tab(page, "Target")
    page.get_by_label("large (deg)").fill("20")
    until(lambda: pictures(page) > before)
    until(still)


def drives_instead(page: Any, other: Any) -> bool:
    pressed(page, "Drive from here")
    pressed(other, "Hand over")
    return "this page drives" in page.inner_text("header")


def test_another_page_looks_on_until_it_is_handed_the_rig(panel: Served, browser: Any, page: Any) -> None:
    ready(page)
    other = panel.page(browser, 768, 1024)

    def vents(seen: Any, onlooker: Any) -> bool:
        if not drives_instead(seen, onlooker):
            return False
        onwards(seen, state(seen))
        return bool(seen.get_by_role("button", name="Vent").is_enabled())

    def looks_on(seen: Any) -> bool:
        return not any(seen.get_by_role("button", name=name).is_enabled() for name in ("Vent", "large, forwards"))

    until(lambda: vents(page, other) and looks_on(other), 60.0)
    until(lambda: vents(other, page) and looks_on(page), 60.0)
    until(lambda: vented(other))
    until(lambda: drives_instead(page, other))
    other.context.close()


def test_by_keyboard_alone(page: Any) -> None:
    page.get_by_role("button", name="Start").focus()
    page.keyboard.press("Enter")
    ready(page)
    before = angle(page)
    button = page.get_by_role("button", name=inwards(page, "large"))

    def moved() -> bool:
        return abs(angle(page) - before) > 4.0

    for _ in range(5):
        ready(page)
        until(lambda: button.is_enabled() or held(page))
        button.focus()
        page.keyboard.down("Space")
        until(lambda: moved() or held(page))
        page.keyboard.up("Space")
        if moved():
            break
    assert moved()
    ready(page)
    page.keyboard.press("Escape")
    until(lambda: state(page) == "Holding")


def test_a_flood_of_connections_leaves_page_and_loop_alone(panel: Served, page: Any) -> None:
    ready(page)
    address = urlsplit(panel.link)
    with ExitStack() as open_ones:
        for _ in range(FLOOD):
            one = open_ones.enter_context(socket.socket())
            one.setblocking(False)
            one.connect_ex((address.hostname, address.port))
        before = angle(page)
        jogged(page, inwards(page, "large"), lambda: abs(angle(page) - before) > 4.0)
        page.mouse.up()
        late = page.locator(".lf-figures dd", has_text="worst").inner_text()
        assert float(late.split()[0]) < 1000.0, late


def test_values_out_of_range_are_told_and_go_nowhere(page: Any) -> None:
    tab(page, "Target")
    page.get_by_label("small (deg)").fill("500")
    until(lambda: "outside the working stroke" in page.inner_text("main"))
    assert not page.get_by_role("button", name="Go to target").is_enabled()
    page.get_by_label("tip x (mm)").fill("5000")
    page.get_by_label("tip y (mm)").fill("0")
    press(page, "Find angles that bring the tip there")
    until(lambda: "out of the arm's reach" in page.inner_text("main"))


def added(page: Any) -> list[str]:
    """What is on after each step of the sequence; a row that is just being drawn lacks it."""
    rows = [row.split("\t") for row in page.locator("main .lf-table tr").all_inner_texts()[1:]]
    return [row[3] if len(row) > 3 else "" for row in rows]


def test_sequences_are_run_saved_and_loaded(page: Any) -> None:
    ready(page)
    tab(page, "Moves")
    press(page, "Add present angles")
    tab(page, "Jog")
    jogged(page, "small, forwards", lambda: angle(page, 1) > 10.0)
    page.mouse.up()
    time.sleep(0.6)
    press(page, "Switch gripper on")
    until(lambda: page.get_by_role("button", name="Switch gripper off").is_visible())
    tab(page, "Moves")
    press(page, "Add present angles")
    until(lambda: added(page) == ["nothing", "gripper"])
    page.get_by_label("name").fill("to and fro")
    press(page, "Save")
    until(lambda: "saved build" in page.inner_text("main"))
    press(page, "Clear")
    until(lambda: page.locator("main .lf-table tr").count() == 0)
    press(page, "Load")
    until(lambda: page.locator("main .lf-table tr").count() == 3)

    def performed() -> bool:
        if held(page) or "at step" not in page.inner_text("main"):
            ready(page)
            pressed(page, "Run again and again")
        return "at step 2" in page.inner_text("main")

    until(performed, 60.0)

    def shown(switched: str) -> bool:
        if held(page):  # then it performs anew
            tab(page, "Moves")
            performed()
            tab(page, "Jog")
        return bool(page.locator(".lf-outputs .lf-number").inner_text() == switched)

    tab(page, "Jog")
    for switched in ("on", "off"):
        until(lambda on=switched: shown(on), 60.0)  # type: ignore[misc]
    until(lambda: stopped(page))


def test_the_check_before_first_air(page: Any) -> None:
    tab(page, "Check")
    until(lambda: page.get_by_role("button", name="Check without air").is_enabled(), 60.0)
    press(page, "Check without air")
    until(lambda: page.locator("main .lf-table tr").count() > 5, 30.0)
    until(lambda: state(page) == "Off", 30.0)


def test_every_tab_passes_an_accessibility_check_and_fits_a_tablet(page: Any) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    for name in ("Jog", "Target", "Moves", "Check", "Controller", "Logs", "Failures"):
        tab(page, name)
        for width in (768, 1280):
            page.set_viewport_size({"width": width, "height": 800})
            page.wait_for_timeout(200)
            assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), name
        found = axe.run(page).response["violations"]
        serious = [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in {"serious", "critical"}]
        assert not serious, name
