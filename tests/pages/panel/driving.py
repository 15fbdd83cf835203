"""What a person does on the operator's page, and sees there."""

import inspect
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest

sync_api = pytest.importorskip("playwright.sync_api")
TimeoutError = sync_api.TimeoutError
REST, OBEYS = {"Off", "Stopped"}, {"Ready", "Moving"}
PATIENCE = 1000.0  # with a button that may be taken away meanwhile, ms


def until(condition: Callable[[], bool], seconds: float = 30.0) -> float:
    begun = time.monotonic()
    while not condition():
        assert time.monotonic() - begun < seconds, inspect.getsource(condition)
        time.sleep(0.02)
    return time.monotonic() - begun


def state(page: Any) -> str:
    return str(page.locator(".lf-state").inner_text())


def angle(page: Any, joint: int = 0) -> float:
    return float(page.locator(".lf-joints .lf-number").nth(joint).inner_text().split()[0])


def inwards(page: Any, name: str, joint: int = 0) -> str:
    """Return the button that jogs a joint to the middle of its stroke, from wherever an earlier test left it."""
    return f"{name}, {'backwards' if angle(page, joint) > 0.0 else 'forwards'}"


def press(page: Any, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def pressed(page: Any, name: str) -> None:
    """Press a button if it can be pressed now: a rig that is held meanwhile may take it away at any time."""
    button = page.get_by_role("button", name=name, exact=True)
    with suppress(TimeoutError):
        if button.is_visible() and button.is_enabled(timeout=PATIENCE):
            button.click(timeout=PATIENCE)


def tab(page: Any, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def drives(page: Any) -> bool:
    pressed(page, "Drive from here")
    return "this page drives" in page.inner_text("header")


def vented(page: Any) -> bool:
    pressed(page, "Heal")
    pressed(page, "Reset")
    pressed(page, "Vent")
    return state(page) in REST


def stopped(page: Any) -> bool:
    if state(page) != "Holding":
        pressed(page, "Stop")
    return state(page) == "Holding"


def onwards(page: Any, found: str) -> None:
    """Press what brings the rig on: where page or device pause on a busy computer it is held, stops, or trips."""
    pressed(page, "Drive from here")
    pressed(page, {"Holding": "Go on", "Fault": "Reset"}.get(found, "Start"))


def held(page: Any) -> bool:
    return state(page) not in OBEYS


def ready(page: Any) -> None:
    """Bring the air."""

    def obeys() -> bool:
        onwards(page, state(page))
        return not held(page)

    until(obeys, 60.0)


def faulted(page: Any) -> bool:
    """Whether the rig has tripped; one that was stopped meanwhile is started, since without air little can be seen."""
    found = state(page)
    if found != "Fault":
        onwards(page, found)
    return found == "Fault"


def jogged(page: Any, name: str, condition: Callable[[], bool]) -> None:
    """Hold a button until a condition holds, anew where the rig was held meanwhile; it is not released at the end."""
    button = page.get_by_role("button", name=name)
    for _ in range(10):
        ready(page)
        until(lambda: button.is_enabled() or held(page))
        box = button.bounding_box()
        page.mouse.move(box["x"] + 5, box["y"] + 5)
        page.mouse.down()
        until(lambda: condition() or held(page), 60.0)
        if condition():
            return
        page.mouse.up()
    raise AssertionError(name)
