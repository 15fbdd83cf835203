"""What the cell does now and how fast; once the run has ended, what came of it."""

from math import isfinite

from nicegui import ui

from layflat.pages.cell.desk import Desk
from layflat.pages.cell.snapshot import About, Snapshot, Stage
from layflat.pages.look import theme

PACES = {False: "real time", True: "as fast as it computes"}
NEAR = 0.1  # share by which a pace that counts as real time may be off; what is held to it makes up for delays
CALIBRATES = "Images of a board show how the camera sees; then the cell begins. The first time, laws are compiled."
STAYS = "This page stays until the command is ended by Ctrl-C in its terminal."


class NowView:
    """Which pick is being done, in which phase, and how far the run is."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
        self._asked, self._picks = desk.asked, desk.about.picks
        with ui.element("div").props("id=cell-now") as self._box, theme.panel("Now") as head:
            with head:
                ui.label("Pace:").props('id="cell-pace"')
                self.pace = ui.toggle(PACES, value=self._asked.fast, on_change=self._set_pace)
                self.pace.props('no-caps unelevated padding="0.1rem 0.6rem" toggle-color=primary')
                self.pace.props('aria-labelledby="cell-pace"')
            self.what = ui.label().classes("ce-what").props("id=cell-what")
            self.doing = ui.label().props("id=cell-doing")
            self.bar = ui.linear_progress(show_value=False, color="primary", size="0.6rem")
            self.bar.props("id=cell-progress instant-feedback")

    def refresh(self, shot: Snapshot) -> None:
        """Show what is being done."""
        self._box.set_visibility(shot.stage is not Stage.ENDED)
        done = shot.figures.picks
        if shot.stage is Stage.CALIBRATES:
            what, doing, share = f"{Stage.CALIBRATES.value}: {shot.calibrated:.0%}", CALIBRATES, shot.calibrated
        else:
            number = min(done + 1, self._picks)
            what = f"Pick {number} of {self._picks}" + (f": {shot.fruit}" if shot.fruit else "")
            doing, share = shot.doing, done / self._picks
        self.what.set_text(what)
        self.doing.set_text(doing)
        self.bar.set_value(round(share, 3))
        self.bar.props["aria-label"] = f"{share:.0%} done"

    def refresh_pace(self) -> None:
        """Show the pace that was chosen, on this page or another."""
        if self.pace.value != self._asked.fast:
            self.pace.set_value(self._asked.fast)

    def _set_pace(self) -> None:
        self._asked.fast = bool(self.pace.value)


class EndView:
    """How the run ended, what came of it, and where that was written."""

    def __init__(self, about: About) -> None:
        """Build it."""
        self._about = about
        with ui.element("div").props("id=cell-end role=status") as self._box:
            pass
        self._box.set_visibility(False)

    def refresh(self, shot: Snapshot) -> None:
        """Show it once there is something to show."""
        if shot.stage is not Stage.ENDED:
            return
        done = f"{Stage.ENDED.value}: {shot.figures.picks} of {self._about.picks} picks."
        early = f"{Stage.ENDED.value} early: {shot.error}"
        self._box.clear()
        self._box.set_visibility(True)
        with self._box, theme.panel("Result"):
            theme.note(early if shot.error else done, "warning" if shot.error else "good")
            _list(shot.summary)
            _list(tuple(f"wrote {path}" for path in shot.written))
            ui.label(STAYS).classes("lf-quiet lf-small")


def pace_words(pace: float, *, fast: bool) -> str:
    """Return how fast a simulation goes, behind its name; empty where that is not known."""
    if not isfinite(pace):
        return ""
    if fast and pace > 1.0 + NEAR:
        return f", {pace:.1f} times as fast as real time"
    return ", in real time" if pace >= 1.0 - NEAR else f", at {pace:.2f} of real time"


def _list(lines: tuple[str, ...]) -> None:
    if lines:
        with ui.element("ul").classes("ce-list"):
            for line in lines:
                theme.text_element("li", line)
