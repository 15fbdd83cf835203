"""Questions that a page asks before it does something."""

from nicegui import ui

from layflat.pages.look import theme


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
