"""Questions that a page asks before it does something, and numbers that a browser sends: finite, or none."""

from math import isfinite
from typing import Any

from nicegui import ui

from layflat.pages.look import theme


def number(value: Any) -> float | None:
    """Return what a field holds as a number; None where it holds none, or one that is not finite."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if abs(value) < 1e300 and isfinite(value) else None


def within(value: Any, lower: float, upper: float, otherwise: float) -> float:
    """Return the number that a slider holds, inside its limits; `otherwise` where it holds none."""
    found = number(value)
    return otherwise if found is None else min(max(found, lower), upper)


async def confirmed(question: str, yes: str, no: str = "Cancel") -> bool:
    """Ask a question, and return whether it was answered by the button `yes`; Escape is a no."""
    with ui.dialog() as dialog, ui.card().classes("lf-dialog").props("role=dialog aria-modal=true"):
        ui.label(question)
        with ui.row().classes("lf-line"):
            theme.button(yes, lambda: dialog.submit(True), kind="primary").props("autofocus")
            theme.button(no, lambda: dialog.submit(False))
    answer = await dialog
    dialog.delete()
    return bool(answer)
