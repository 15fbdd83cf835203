"""Pictures of the pages, as the docs show them, from real pages in a real browser, and of a joint: `make pictures`.

Needs chromium, OpenGL, and the extras `panel`, `cell`, `cad`, `view` and `test`.
"""

import tempfile
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import TimeoutError

from docs import exploded
from tests.pages.browsers import chromium, served

FOLDER = Path(__file__).parent
SIZE = (1280, 900)
SOLIDS_TIME = 30_000  # within which the solids of an arm at rest are made and drawn, ms


def panel(page: Any) -> None:
    """Send an arm to two targets on the operator's panel, and wait until it is on its way to a third.

    It rests before, until its solids are drawn.
    """
    page.wait_for_timeout(SOLIDS_TIME)
    for angles, seconds in (((35, 25, -40, 20), 8.0), ((-30, -10, 30, -15), 7.0), ((40, 30, -20, 25), 1.2)):
        page.get_by_role("tab", name="Target", exact=True).click()
        for joint, angle in zip(("base", "shoulder", "elbow", "wrist"), angles, strict=True):
            page.get_by_label(f"{joint} (deg)").fill(str(angle))
        until_it_moves(page)
        page.wait_for_timeout(1000 * seconds)


def until_it_moves(page: Any) -> None:
    """Click Start, Go on and Go to target, as far as they are enabled, until the panel shows that the arm moves.

    Raise RuntimeError after 600 attempts.
    """
    going = page.locator(".lf-state", has_text="Moving")
    for _ in range(600):
        for name in ("Start", "Go on", "Go to target"):
            button = page.get_by_role("button", name=name, exact=True)
            if button.is_visible() and button.is_enabled():
                with suppress(TimeoutError):
                    button.click(timeout=300)
        page.wait_for_timeout(200)
        if going.is_visible():
            return
    raise RuntimeError("panel: the arm does not move after 600 clicks on Start, Go on and Go to target")


def studio(page: Any) -> None:
    """Widen a hose in the studio to 180 mm, with the design before kept as A, and wait for the results."""
    current = "() => document.querySelector('.st-row') && !document.querySelector('.st-old')"
    page.wait_for_function(current, timeout=120_000)
    page.get_by_role("button", name="Keep as A").click()
    width = page.get_by_role("textbox", name="Joint large, hose, Width in mm")
    width.fill("180")
    width.press("Enter")
    page.wait_for_timeout(1000)
    page.wait_for_function(current, timeout=120_000)


def watch(page: Any) -> None:
    """Run the packing cell up to its third pick, then 2.5 s in real time, so that a fruit is carried."""
    page.get_by_role("button", name="as fast as it computes").click()
    carried = "() => parseInt(document.querySelector('#cell-picks').innerText) > 2"
    page.wait_for_function(carried, timeout=120_000)
    page.get_by_role("button", name="real time").click()
    page.wait_for_timeout(2500)


def ended(page: Any) -> None:
    """Run the packing cell, as fast as it computes, until the run has ended by itself."""
    page.get_by_role("button", name="as fast as it computes").click()
    page.wait_for_selector("#cell-end", timeout=120_000)


def taken(
    words: tuple[str, ...], name: str, act: Callable[[Any], None], then: Callable[[Any], None] | None = None
) -> None:
    """Serve a page, call `act` with it, write a picture of it to docs/NAME.png, and call `then` with it.

    `words` is the command line that serves the page.
    """
    with tempfile.TemporaryDirectory() as folder, served(Path(folder), *words) as found, chromium() as browser:
        page = found.page(browser, *SIZE)
        act(page)
        Image.open(BytesIO(page.screenshot())).convert("RGB").save(FOLDER / f"{name}.png", optimize=True)
        if then is not None:
            then(page)


def main() -> None:
    """Write the pictures of a joint's parts, and of panel, studio and packing cell."""
    exploded.main()
    taken(("panel", "picking-arm"), "panel", panel)
    taken(("studio", "paper-arm"), "studio", studio)
    taken(("cell", "pack", "--watch", "--picks", "5"), "watch", watch, ended)


if __name__ == "__main__":
    main()
