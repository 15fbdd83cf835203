"""How long each handler of the pages holds up the event loop that serves them, with hard inputs.

    python -m benchmarks.pages [panel] [studio] [cell]

A visitor that speaks the protocol of a browser presses every button while a virtual arm moves. Printed is the longest
work of the loop's thread in one turn, which others on the computer hardly change. Needs the extras `panel` and `test`.
"""

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from tests.pages.browsers import PATIENT, served
from tests.pages.cell.feeding import FED
from tests.pages.turning import KEPT, Turns
from tests.pages.visitor import Visitor, page_text

FILES = 10_000  # in the folder of logs and sequences
STEPS = 500  # of a sequence
MANY = 20  # pages that are opened at once
SETTLES = 1.5  # after what was pressed, s
Row = tuple[str, Callable[[], object], float]
"""A row of the table: what is done, how, and how long its effects last, s."""


def fill(folder: Path) -> None:
    """Put many files into a panel's folder."""
    folder.mkdir(parents=True)
    for number in range(FILES):
        (folder / f"other-{number}.mcap").touch()
        (folder / f"other-{number}.sequence.toml").touch()


def panel_rows(visitor: Visitor, link: str) -> Iterator[Row]:
    """All handlers of the panel."""
    press, enter = visitor.press, visitor.enter

    yield "timers, lease and charts at rest", lambda: None, 5.0
    yield "Start", lambda: press("Start"), 4.0
    yield "jog of a joint", lambda: setattr(visitor, "jogs", ["0:1"]), 2.0
    yield "release of the jog", visitor.jogs.clear, 1.0
    yield "another page opened and closed", lambda: look_on(link, 1), 2.0
    yield f"{MANY} more pages opened at once, and closed", lambda: look_on(link, MANY), 4.0
    yield f"Add present angles, {STEPS} steps", lambda: [press("Add present angles") for _ in range(STEPS)], 15.0
    yield "Save a sequence", several(lambda: enter("name", "long"), lambda: press("Save")), 3.0
    yield "Load a sequence", several(lambda: enter("saved", saved_option(visitor, "long")), lambda: press("Load")), 3.0
    yield "Run again and again", lambda: press("Run again and again"), 3.0
    for axis, value in zip("xyz", (0, 0, 1200), strict=True):
        enter(f"tip {axis} (mm)", value)
    yield "Find angles, out of reach, 200 times", lambda: [press(FIND) for _ in range(200)], 6.0
    yield "an angle typed", lambda: enter(f"{next(iter(JOINTS))} (deg)", 12.5), 1.0
    yield "Go to target", lambda: press("Go to target"), 2.0
    slider = next(
        found for found in visitor.each() if found[1].get("props", {}).get("aria-labelledby") == "reach-height"
    )
    yield "height of the green surface", lambda: visitor.emit(slider, "change", 100), 5.0
    yield "another control law chosen, and back", lambda: press("Back to what is in use"), 2.0
    yield "Fail and Heal", several(lambda: press("Fail"), lambda: press("Heal")), 3.0
    yield f"Look again, {FILES} logs", lambda: press("Look again"), 3.0
    yield "Plot a log", lambda: press(next(name for name in names(visitor) if name.startswith("Draw "))), 10.0
    yield "Clear", lambda: press("Clear"), 4.0
    yield "Stop", lambda: press("Stop"), 1.0
    yield "Vent", lambda: press("Vent"), 4.0
    yield "Check without air", lambda: press("Check without air"), 15.0


def look_on(link: str, pages: int) -> None:
    """Open pages at the same time, look on for a while, and close them."""
    with ThreadPoolExecutor(pages) as pool, ExitStack() as stack:
        for visitor in pool.map(Visitor, [link] * pages):
            stack.enter_context(visitor)
        time.sleep(4.0)


JOINTS = ("base",)
FIND = "Find angles that bring the tip there"


def saved_option(visitor: Visitor, name: str) -> Any:
    """The option of a saved sequence."""
    (_, found), _ = visitor.find("saved", "update:modelValue")
    options = found["props"]["options"]
    return next((one for one in options if one["label"] == name), options[0])


def names(visitor: Visitor) -> list[str]:
    """Names of all elements for readers of screens."""
    return [str(one.get("props", {}).get("aria-label")) for _, one in visitor.each()]


def studio_rows(visitor: Visitor, link: str) -> Iterator[Row]:
    """The heavy handlers of the studio."""
    press, enter = visitor.press, visitor.enter
    yield "timers at rest", lambda: None, 3.0
    yield "another page opened and closed", lambda: look_on(link, 1), 2.0
    yield f"{MANY} more pages opened at once, and closed", lambda: look_on(link, MANY), 8.0
    yield "all sections opened", lambda: open_sections(visitor), 6.0
    yield "an edit by its field", several(lambda: enter(WIDTH, "111"), lambda: leave(visitor, WIDTH)), 3.0
    yield "an edit by its slider", lambda: enter(f"Slider: {WIDTH}", 120.0), 3.0
    yield "Undo", lambda: press("Undo (Ctrl-Z)"), 3.0
    yield "search that finds all values", lambda: enter("Search values of the description", "joint"), 4.0
    yield "search ended", lambda: enter("Search values of the description", ""), 2.0
    yield "Keep as A", lambda: press("Keep as A, to compare with"), 6.0
    yield "Tune opened", lambda: press("Tune the gains"), 1.0
    yield "Report asked for", lambda: press("Report as a page"), 2.0
    yield "Report written", lambda: press("Save"), 10.0
    yield "Tune begun and closed", several(lambda: press("Begin"), lambda: time.sleep(2.0), lambda: press("Close")), 2.0


WIDTH = "Joint base, hose, Width in mm"


def open_sections(visitor: Visitor) -> None:
    """Open all parts of the description, so that all values are on the page."""
    for found in visitor.each():
        if "st-section" in found[1].get("class", []):
            visitor.emit(found, "update:modelValue", True)


def leave(visitor: Visitor, name: str) -> None:
    """Leave a field, by which what was typed is taken."""
    visitor.emit(*visitor.find(name, "blur"), None)


def cell_rows(visitor: Visitor, link: str) -> Iterator[Row]:
    """All handlers of the page of a packing run."""
    press = visitor.press
    yield "images, figures and picks of a run", lambda: see_images(visitor, 8.0), 0.0
    yield "another page opened and closed", lambda: look_on(link, 1), 2.0
    yield f"{MANY} more pages opened at once, and closed", lambda: look_on(link, MANY), 4.0
    yield "another pace", lambda: visitor.emit(toggle_of(visitor), "update:modelValue", 1), 2.0
    yield "Enlarge, and closed", several(lambda: press("Enlarge"), lambda: see_images(visitor, 2.0),
                                         lambda: press("Close")), 1.0  # fmt: skip
    yield "Stop, and cancelled", several(lambda: press("Stop"), lambda: time.sleep(1.0), lambda: press("Cancel")), 1.0


def toggle_of(visitor: Visitor) -> tuple[int, dict[str, Any]]:
    """The element that chooses the pace."""
    return next(found for found in visitor.each() if found[1].get("tag") == "q-btn-toggle")


def see_images(visitor: Visitor, seconds: float) -> None:
    """Load each image that the page shows, as a browser does."""
    loaded, end = dict[int, str](), time.monotonic() + seconds
    while time.monotonic() < end:
        for number, one in visitor.each():
            source = one.get("props", {}).get("src")
            if source and loaded.get(number) != source and str(source).startswith("/run/"):
                loaded[number] = source
                page_text(visitor.origin, visitor.cookie, source)
                visitor.emit((number, one), "load", None)
        time.sleep(0.02)


def several(*works: Callable[[], object]) -> Callable[[], object]:
    """One work after the other."""
    return lambda: [work() for work in works]


def measure(rows: Iterator[Row], turns: Turns) -> None:
    """Do what rows say, and print the longest turn of each."""
    for name, work, lasts in rows:
        turns.begin()
        try:
            work()
        except AssertionError as error:
            print(f"| {name} | not measured: {str(error)[:60]} | |", flush=True)
            continue
        time.sleep(SETTLES + lasts)
        turn = turns.longest()
        names = (one.removeprefix("layflat.pages.") for one in (turn.handler, turn.inside))
        print(f"| {name} | {1e3 * turn.work:.0f} ms | {', in '.join(dict.fromkeys(names))} |", flush=True)


def main() -> None:
    """Measure the pages that are named, or all."""
    names = sys.argv[1:] or ["panel", "studio", "cell"]
    for name in names:
        print(f"| {name} | longest work in one turn | in |\n|---|---|---|")
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            fill(folder / "build" / "panel")
            before = KEPT + (FED if name == "cell" else PATIENT)
            with served(folder, name, "picking-arm", before=before) as found:
                turns = Turns(folder)
                with Visitor(found.link) as visitor:
                    measure(rows_of(name, visitor, found.link), turns)


def rows_of(name: str, visitor: Visitor, link: str) -> Iterator[Row]:
    """Return the rows of a page once it is built."""
    if name == "cell":
        visitor.until(lambda: "The arm lifts the fruit." in visitor.text, 60.0)
        return cell_rows(visitor, link)
    if name == "studio":
        visitor.until(lambda: bool(visitor.text_of("st-value")) and visitor.text_of("st-value") != "...", 200.0)
        return studio_rows(visitor, link)
    visitor.until(lambda: any(visitor.named("Fail")) and visitor.text_of("lf-state") == "Off", 900.0)
    visitor.until(lambda: any(visitor.named("Look again")), 60.0)
    return panel_rows(visitor, link)


if __name__ == "__main__":
    main()
