"""Images of the run that follow it: the cell as a whole, and what its camera saw last."""

from time import monotonic

from nicegui import ui

from layflat.pages.cell.desk import Desk
from layflat.pages.cell.snapshot import Snapshot
from layflat.pages.look import theme

PATIENCE = 2.0  # after which an image that has not come is given up for a newer one, s
NONE = "No image can be rendered on this computer; the terminal says why. The scene's truth stands in for the camera."


class LiveImage:
    """An image that asks for the next one once it shows the one before, so that a slow browser gets fewer."""

    def __init__(self, desk: Desk, name: str) -> None:
        """Make it within the current element."""
        self._desk, self._name = desk, name
        self._shown, self._waits, self._since = 0, False, 0.0
        with ui.element("div").classes("ce-frame"):
            self.box = ui.element("img").classes("ce-image").props(f"id=cell-{name}")
            self._none = ui.label("No image yet").classes("lf-quiet")
        self.box.set_visibility(False)
        self.box.on("load", self._loaded, args=[])

    def refresh(self, text: str) -> None:
        """Show the newest, and say what is in it."""
        number, now = self._desk.numbers[self._name], monotonic()
        self.box.props["alt"] = text
        if number > self._shown and not (self._waits and now - self._since < PATIENCE):
            self._shown, self._waits, self._since = number, True, now
            self.box.props["src"] = f"/run/{self._name}.jpg?n={number}"
            self.box.set_visibility(True)
            self._none.set_visibility(False)

    def _loaded(self) -> None:
        self._waits = False


class ImagesView:
    """Both images, or why there are none."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
        with ui.element("div").props("id=cell-no-images") as self._none:
            theme.note(NONE, "warning")
        with ui.element("div").classes("ce-images") as self._some:
            with theme.panel("The cell"):
                self.overview = LiveImage(desk, "overview")
            with theme.panel("The camera's last image") as head:
                with head:
                    theme.button("Enlarge", self._enlarge, icon="zoom_in", kind="flat").props("dense")
                self.camera = LiveImage(desk, "camera")
                self.seen = ui.label().classes("lf-quiet lf-small").props("id=cell-seen")
        with ui.dialog().props("maximized") as self._dialog, ui.card().classes("ce-large") as card:
            card.props('role=dialog aria-modal=true aria-label="The camera\'s last image"')
            theme.button("Close", self._dialog.close, kind="primary").props("autofocus")
            self.large = LiveImage(desk, "camera")
            self.large.box.props("id=cell-camera-large")

    def refresh(self, shot: Snapshot) -> None:
        """Follow the run."""
        self._none.set_visibility(not shot.images)
        self._some.set_visibility(shot.images)
        if not shot.images:
            return
        seen = f"What the camera sees: {shot.seen}" if shot.seen else "What the camera sees"
        self.overview.refresh("The cell from the side: " + (shot.doing or "before it begins"))
        self.camera.refresh(seen)
        self.seen.set_text(f"Seen: {shot.seen}" if shot.seen else "")
        if self._dialog.value:
            self.large.refresh(seen)

    def _enlarge(self) -> None:
        self._dialog.open()
