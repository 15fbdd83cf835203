"""The operator's panel beside its loop: lateness of the loop, beats of the page, memory, over many minutes.

    python -m benchmarks.panel [NAME] [MINUTES]

A virtual rig runs a sequence again and again, with its page open in a browser; then, for comparison, its loop runs for
as long alone. Needs chromium, and the extras `panel` and `test`.
"""

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import TimeoutError

from layflat.cli.pages import VirtualBench
from layflat.identify.logs.formats import read_table
from layflat.machine import load
from layflat.rig.recorded import RecordedSession
from layflat.rig.safety.faults import RigState
from tests.pages.browsers import Served, chromium, served

LOOKS = 5.0  # between two looks at the page, s
BEATS = """() => {
  window.beats = [];
  const watch = new MutationObserver(() => window.beats.push(performance.now()));
  watch.observe(document.querySelector("[data-beat]"), {attributes: true});
}"""


def processes(root: int) -> Iterator[int]:
    """A process and all that it has started."""
    yield root
    for task in Path(f"/proc/{root}/task").iterdir():
        with suppress(OSError):
            for child in (task / "children").read_text().split():
                yield from processes(int(child))


def megabytes(root: int) -> float:
    """Memory of a process and all that it has started, shared pages by shares."""
    total = 0
    for pid in processes(root):
        with suppress(OSError):
            rows = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
            total += next(int(row.split()[1]) for row in rows if row.startswith("Pss:"))
    return total / 1024.0


def kept_going(page: Any) -> bool:
    """Continue the arm's sequence; return whether it was held before."""
    page.get_by_role("tab", name="Moves", exact=True).click()
    if "at step" in page.inner_text("main"):
        return False
    for name in ("Start", "Go on", "Run again and again"):
        button = page.get_by_role("button", name=name, exact=True)
        with suppress(TimeoutError):
            if button.is_visible() and button.is_enabled(timeout=300):
                button.click(timeout=300)
    return True


def with_page(found: Served, minutes: float) -> None:
    """Watch the page for so long, and print what comes of it a minute."""
    with chromium() as browser:
        page = found.page(browser)
        page.get_by_role("tab", name="Moves", exact=True).click()
        for state in ("Ready", "Moving"):
            while page.locator(".lf-state").inner_text() not in {"Ready", state}:
                kept_going(page)
                page.wait_for_timeout(300)
            page.get_by_role("button", name="Add present angles").click()
        page.evaluate(BEATS)
        tools = page.context.new_cdp_session(page)
        tools.send("HeapProfiler.enable")
        begun, looks, idle, printed = time.monotonic(), 0, 0, 0
        while (passed := time.monotonic() - begun) < 60.0 * minutes:
            looks, idle = looks + 1, idle + kept_going(page)
            page.wait_for_timeout(1e3 * LOOKS)
            if passed >= 60.0 * printed:
                printed += 1
                gaps = np.diff(page.evaluate("() => window.beats.splice(0)"))
                tools.send("HeapProfiler.collectGarbage")
                heap = tools.send("Runtime.getHeapUsage")["usedSize"] / 1e6
                print(
                    f"{passed / 60.0:4.0f} min: beats every {np.median(gaps):.0f} ms, worst {gaps.max():.0f} ms; "
                    f"server, loop and recorder {megabytes(found.process.pid):.0f} MB, page {heap:.0f} MB; "
                    f"held at {idle} of {looks} looks",
                    flush=True,
                )


def alone(name: str, minutes: float, log: Path) -> None:
    """Run the loop of the same rig for so long without a page: joints to and fro."""
    machine = load(name)
    bench = VirtualBench(machine)
    driver, address = bench.connect(machine)
    with closing(bench), RecordedSession(machine, driver, address, log) as recorded:
        rig = recorded.session
        rig.start()
        begun = time.monotonic()
        while (passed := time.monotonic() - begun) < 60.0 * minutes:
            shot = rig.snapshot()
            if shot is not None and shot.state in {RigState.READY, RigState.MOVING}:
                rig.ask([0.3 * np.sin(0.5 * passed)] * len(machine.joints))
            time.sleep(0.05)


def told(name: str, log: Path) -> None:
    """Print how late the loop was, by its log."""
    columns = read_table(log).columns
    late, elapsed = 1e6 * columns["lateness"].values, columns["elapsed"].values
    missed = int((elapsed > 1.5 * np.median(elapsed)).sum())
    median, most = np.quantile(late, (0.5, 0.99))
    print(
        f"{name}: {len(late)} cycles, late by {median:.1f} us, 99 % {most:.0f} us, worst {late.max():.0f} us; "
        f"{missed} missed deadlines"
    )


def main() -> None:
    """Measure with the page, then without."""
    name = sys.argv[1] if len(sys.argv) > 1 else "picking-arm"
    minutes = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        with served(place, "panel", name) as found:
            with_page(found, minutes)
        told("with the page", next(place.rglob("*-panel.mcap")))
        alone(name, minutes, place / "alone.mcap")
        told("alone", place / "alone.mcap")


if __name__ == "__main__":
    main()
