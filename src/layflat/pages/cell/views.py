"""Views of a run: present pick and pace, images, figures, last picks, and the end of the run."""

from collections import Counter
from math import isfinite
from time import monotonic

from nicegui import ui

from layflat.pages.cell.desk import RunFeed
from layflat.pages.cell.snapshot import MAX_PICK_ROWS, RunSnapshot, RunStage, RunSubject
from layflat.pages.look import theme

PACE_LABELS = {False: "real time", True: "as fast as it computes"}
REAL_TIME_TOLERANCE = (
    0.1  # share by which a pace that counts as real time may be off; what is held to it makes up for delays
)
CALIBRATION_TEXT = (
    "Images of a board show how the camera sees; then the cell begins. The first time, laws are compiled."
)
STAYS_OPEN_TEXT = "This page stays until the command is ended by Ctrl-C in its terminal."
IMAGE_TIMEOUT = 2.0  # after which an image that has not loaded is replaced by a newer one, s
NO_IMAGES_TEXT = (
    "No image can be rendered on this computer; the terminal says why. The scene's truth stands in for the camera."
)
FIGURE_NAMES = {
    "picks": "Picks",
    "correct": "Correct so far",
    "results": "Results",
    "rate": "Rate",
    "air": "Air",
    "collisions": "Collisions",
    "false": "False detections",
    "time": "Time of the cell",
    "delivery": "Delivery",
}
"""Names of figures, by the last part of their elements' ids."""
TRUTH_TEXT = "Whether a pick is correct is judged by the scene's truth, for good once its delivery is over."


class NowView:
    """View of the pick that is being done, its phase, and the progress of the run."""

    def __init__(self, feed: RunFeed) -> None:
        """Build the view within the current element."""
        self._requests, self._picks = feed.requests, feed.about.picks
        with ui.element("div").props("id=cell-now") as self._box, theme.panel("Now") as head:
            with head:
                ui.label("Pace:").props('id="cell-pace"')
                self.pace = ui.toggle(PACE_LABELS, value=self._requests.full_speed, on_change=self._set_pace)
                self.pace.props('no-caps unelevated padding="0.1rem 0.6rem" toggle-color=primary')
                self.pace.props('aria-labelledby="cell-pace"')
            self.what = ui.label().classes("ce-what").props("id=cell-what")
            self.doing = ui.label().props("id=cell-doing")
            self.bar = ui.linear_progress(show_value=False, color="primary", size="0.6rem")
            self.bar.props("id=cell-progress instant-feedback")

    def refresh(self, shot: RunSnapshot) -> None:
        """Show the present pick, the action of the arm, and the progress; hide the view once the run has ended."""
        self._box.set_visibility(shot.stage is not RunStage.ENDED)
        done = shot.figures.picks
        if shot.stage is RunStage.CALIBRATES:
            what, doing, share = (
                f"{RunStage.CALIBRATES.value}: {shot.calibrated:.0%}",
                CALIBRATION_TEXT,
                shot.calibrated,
            )
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
        if self.pace.value != self._requests.full_speed:
            self.pace.set_value(self._requests.full_speed)

    def _set_pace(self) -> None:
        self._requests.full_speed = bool(self.pace.value)


class EndView:
    """View of the end of the run, its results, and the files that hold them."""

    def __init__(self, about: RunSubject) -> None:
        """Build the view within the current element."""
        self._about = about
        with ui.element("div").props("id=cell-end role=status") as self._box:
            pass
        self._box.set_visibility(False)

    def refresh(self, shot: RunSnapshot) -> None:
        """Show the results, or the error that ended the run early; nothing before the run has ended."""
        if shot.stage is not RunStage.ENDED:
            return
        done = f"{RunStage.ENDED.value}: {shot.figures.picks} of {self._about.picks} picks."
        early = f"{RunStage.ENDED.value} early: {shot.error}"
        self._box.clear()
        self._box.set_visibility(True)
        with self._box, theme.panel("Result"):
            theme.note(early if shot.error else done, "warning" if shot.error else "good")
            _add_list(shot.summary)
            _add_list(tuple(f"wrote {path}" for path in shot.written))
            ui.label(STAYS_OPEN_TEXT).classes("lf-quiet lf-small")


def describe_pace(pace: float, *, fast: bool) -> str:
    """Describe a pace (cell time over real time), to follow "A simulation"; empty where the pace is not finite."""
    if not isfinite(pace):
        return ""
    if fast and pace > 1.0 + REAL_TIME_TOLERANCE:
        return f", {pace:.1f} times as fast as real time"
    return ", in real time" if pace >= 1.0 - REAL_TIME_TOLERANCE else f", at {pace:.2f} of real time"


def _add_list(lines: tuple[str, ...]) -> None:
    """Add a list with a point for each line; nothing if there are none."""
    if lines:
        with ui.element("ul").classes("ce-list"):
            for line in lines:
                theme.text_element("li", line)


class LiveImage:
    """Image of the run that loads the newest frame once the previous one is displayed: a slow browser gets fewer."""

    def __init__(self, feed: RunFeed, name: str) -> None:
        """Make it within the current element."""
        self._feed, self._name = feed, name
        self._shown, self._waits, self._since = 0, False, 0.0
        with ui.element("div").classes("ce-frame"):
            self.box = ui.element("img").classes("ce-image").props(f"id=cell-{name}")
            self._none = ui.label("No image yet").classes("lf-quiet")
        self.box.set_visibility(False)
        self.box.on("load", self._loaded, args=[])

    def refresh(self, text: str) -> None:
        """Load the newest image, and set its description for screen readers.

        No image is requested while the last one is being loaded, for `IMAGE_TIMEOUT` at most.
        """
        number, now = self._feed.numbers[self._name], monotonic()
        self.box.props["alt"] = text
        if number > self._shown and not (self._waits and now - self._since < IMAGE_TIMEOUT):
            self._shown, self._waits, self._since = number, True, now
            self.box.props["src"] = f"/run/{self._name}.jpg?n={number}"
            self.box.set_visibility(True)
            self._none.set_visibility(False)

    def _loaded(self) -> None:
        self._waits = False


class ImagesView:
    """Views of both images, or of the reason why there are none."""

    def __init__(self, feed: RunFeed) -> None:
        """Build the view within the current element."""
        with ui.element("div").props("id=cell-no-images") as self._none:
            theme.note(NO_IMAGES_TEXT, "warning")
        with ui.element("div").classes("ce-images") as self._some:
            with theme.panel("The cell"):
                self.overview = LiveImage(feed, "overview")
            with theme.panel("The camera's last image") as head:
                with head:
                    theme.button("Enlarge", self._enlarge, icon="zoom_in", kind="flat").props("dense")
                self.camera = LiveImage(feed, "camera")
                self.seen = ui.label().classes("lf-quiet lf-small").props("id=cell-seen")
        with ui.dialog().props("maximized") as self._dialog, ui.card().classes("ce-large") as card:
            card.props('role=dialog aria-modal=true aria-label="The camera\'s last image"')
            theme.button("Close", self._dialog.close, kind="primary").props("autofocus")
            self.large = LiveImage(feed, "camera")
            self.large.box.props("id=cell-camera-large")

    def refresh(self, shot: RunSnapshot) -> None:
        """Show the newest images, and the counts of fruit in the camera's last one."""
        self._none.set_visibility(not shot.images)
        self._some.set_visibility(shot.images)
        if not shot.images:
            return
        seen = f"What the camera sees: {shot.fruit_counts}" if shot.fruit_counts else "What the camera sees"
        self.overview.refresh("The cell from the side: " + (shot.doing or "before it begins"))
        self.camera.refresh(seen)
        self.seen.set_text(f"Seen: {shot.fruit_counts}" if shot.fruit_counts else "")
        if self._dialog.value:
            self.large.refresh(seen)

    def _enlarge(self) -> None:
        self._dialog.open()


class PickFiguresView:
    """View of the figures of all picks."""

    def __init__(self, about: RunSubject) -> None:
        """Build the view within the current element."""
        self._requests = about.picks
        self._values: dict[str, ui.label] = {}
        with theme.panel("Figures"):
            with ui.element("dl").classes("ce-figures").props("id=cell-figures"):
                for key, name in FIGURE_NAMES.items():
                    self._values[key] = theme.figure(name).props(f"id=cell-{key}")
            ui.label(TRUTH_TEXT).classes("lf-quiet lf-small")

    def refresh(self, shot: RunSnapshot) -> None:
        """Show the figures of a snapshot."""
        figures = shot.figures
        picks = figures.picks
        air_text = f"{figures.air_each:.1f} normal l a pick, {figures.air:.0f} in all"
        texts = {
            "picks": f"{picks} of {self._requests}",
            "correct": f"{figures.results['correct']} of {picks}",
            "results": _format_results(figures.results),
            "rate": f"{figures.picks_a_minute:.1f} a minute" if isfinite(figures.picks_a_minute) else "-",
            "air": air_text if picks else "-",
            "collisions": f"{figures.collisions}",
            "false": f"{figures.false_detections}",
            "time": f"{shot.time:.1f} s",
            "delivery": f"{shot.delivery}",
        }
        for key, label in self._values.items():
            label.set_text(texts[key])


class PicksView:
    """The last picks, a row each, the newest first."""

    def __init__(self, about: RunSubject) -> None:
        """Build the view within the current element."""
        self._remarks: tuple[str, ...] = ()
        with theme.panel("Last picks"):
            with ui.element("div").classes("ce-table").props('tabindex=0 role=region aria-label="Table of picks"'):
                self._table = theme.LabelTable(about.columns, MAX_PICK_ROWS, "id=cell-picks-table")
                self.build = self._table.build
            self._list = ui.element("ul").classes("ce-list").props("id=cell-remarks")

    def refresh(self, shot: RunSnapshot) -> None:
        """Show the last picks of a snapshot, and the remarks on them."""
        self._table.show(shot.rows)
        if shot.remarks != self._remarks:
            self._remarks = shot.remarks
            self._list.clear()
            with self._list:
                for line in shot.remarks:
                    theme.text_element("li", line)


def _format_results(results: Counter[str]) -> str:
    """Return the counts of results, the most frequent first, such as "7 correct, 1 dropped"; "-" without picks."""
    return ", ".join(f"{count} {word}" for word, count in results.most_common()) or "-"
