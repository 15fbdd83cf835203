"""Serve a page with one of each element that takes a value; arguments and all else are those of page.py."""

from tests.pages.server.page import main
from tests.pages.server.page import root as small


def root() -> None:
    from nicegui import ui

    small()
    taken = ui.label("0 taken")

    def take() -> None:
        taken.set_text(f"{int(taken.text.split()[0]) + 1} taken")

    ui.number("a number", value=1.0, format="%.3g", on_change=take)
    ui.input("a text", on_change=take)
    ui.slider(min=0, max=10, value=5, on_change=take).props["aria-label"] = "a slider"
    ui.select(["one", "two", "three"], value="one", label="a choice", on_change=take)
    ui.toggle({False: "no", True: "yes"}, value=False, on_change=take).props["aria-label"] = "a toggle"
    ui.checkbox("a box", on_change=take)
    ui.switch("a switch", on_change=take)
    ui.expansion("a part", on_value_change=take)
    with ui.tabs(on_change=take).props('aria-label="some tabs"') as tabs:
        ui.tab("first")
        ui.tab("second")
    with ui.tab_panels(tabs, value="first").props('aria-label="some panels"'):
        ui.tab_panel("first")
        ui.tab_panel("second")
    with ui.dialog().on_value_change(take).props('aria-label="a dialog"'):
        ui.label("inside")
    ui.keyboard(take).props["aria-label"] = "the keys"
    ui.scene(on_click=take).props["aria-label"] = "a scene"
    taken.set_text("0 taken")  # panels have chosen their tab


if __name__ == "__main__":
    main(root)
