"""What spares a browser from drawing a scene that has not changed; see sparing.js."""

from nicegui import ui
from nicegui.element import Element


class Sparing(Element, component="sparing.js"):
    """An element that shows nothing, and lets a scene be drawn only once it has changed."""

    def __init__(self, scene: ui.scene) -> None:
        """Take a scene without texts that was built before."""
        super().__init__()
        self._props["scene"] = scene.id
