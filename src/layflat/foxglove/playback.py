"""Playback of a run or log to viewers, at any speed; Foxglove's own controls play, pause, seek and change the speed."""

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Dataset
from layflat.errors import InputError
from layflat.foxglove.file import topics_of
from layflat.foxglove.server import DEFAULT_PORT, LOCAL_HOST, ViewerListener, start_server
from layflat.foxglove.signals import NS_PER_SECOND, read_signals
from layflat.foxglove.topics import SCENE_TOPIC
from layflat.machine import Machine

STEP_INTERVAL = 0.02  # between two steps of a playback, s
START_DELAY = 0.3  # from the first subscription of a viewer to the first row, s: its others come meanwhile
MAX_ROW_RATE = 2000.0  # rows that are sent in a second; of more, every second, third ... one


class PlaybackClock:
    """Clock of a playback: stamps between two ends, over time at a speed. Any thread may call its methods.

    Args:
        start: first stamp, ns.
        end: last stamp, ns.
        speed: stamps a time.
        now: clock of the computer, ns.
    """

    def __init__(self, start: int, end: int, speed: float, now: Callable[[], int] = time.monotonic_ns) -> None:
        self.start, self.end, self._now = start, end, now
        self._guard = threading.Lock()
        self._speed, self._playing = speed, False
        self._stamp, self._since = start, now()  # a stamp, and the time at which it was reached
        self._sought: int | None = None

    def read(self) -> tuple[int, int | None]:
        """Return the present stamp, and the one that was sought since the last call; None without any."""
        with self._guard:
            sought, self._sought = self._sought, None
            return self._present(), sought

    def change(self, *, playing: bool, speed: float | None = None, stamp: int | None = None) -> None:
        """Play or pause; a playback that has ended is played anew.

        Args:
            playing: whether to play.
            speed: new speed; default: the present one.
            stamp: stamp from which to continue, ns; default: the present one.
        """
        with self._guard:
            present = self._present()
            if stamp is None and playing and present == self.end:
                stamp = self.start
            self._stamp = present if stamp is None else min(max(stamp, self.start), self.end)
            self._since, self._playing = self._now(), playing
            self._sought = self._sought if stamp is None else self._stamp
            self._speed = self._speed if speed is None else speed

    def state(self) -> tuple[str, int, float]:
        """Return "Playing", "Paused" or "Ended", the present stamp (ns), and the speed."""
        with self._guard:
            present = self._present()
            if self._playing and present == self.end:
                self._playing, self._stamp = False, present
            name = "Playing" if self._playing else "Ended" if present == self.end else "Paused"
            return name, present, self._speed

    def _present(self) -> int:
        passed = (self._now() - self._since) * self._speed if self._playing else 0.0
        return min(self._stamp + round(passed), self.end)


class Playback(AbstractContextManager["Playback"]):
    """Playback of a run or log to all viewers of one server: `with Playback(run) as playback: playback.serve()`.

    It begins when the first viewer subscribes to a topic.

    Args:
        data: run of `rollout`, `open_run` or a rig, or log of `read_log`.
        machine: machine whose arm is shown; default: the one in `data`.
        speed: seconds of the log in a second, until a viewer changes it.
        host: address by which viewers reach this computer.
        port: port of the server; 0: any free one.

    Attributes:
        address: address for Foxglove's "Open connection", ws://HOST:PORT.
        link: link that opens the server in Foxglove's web application.
        shows_arm: whether an arm is shown in space.

    Raises:
        InputError: an argument is wrong, or the port can't be had.
        MissingExtraError: Foxglove's SDK is not installed.

    Example:
        >>> import layflat as lf
        >>> run = lf.rollout("paper-arm", {"large": "20 deg"}, duration="0.5 s")
        >>> with lf.foxglove.Playback(run, speed=0.5, port=0) as playback:
        ...     print(playback.address.rpartition(":")[0])
        ws://127.0.0.1
    """

    def __init__(
        self,
        data: Dataset,
        *,
        machine: str | Path | Machine | None = None,
        speed: float = 1.0,
        host: str = LOCAL_HOST,
        port: int = DEFAULT_PORT,
    ) -> None:
        if not (isfinite(speed) and speed > 0.0):
            raise InputError(f"{speed:g} is not a speed", where="speed", right="give a number above 0, such as 2")
        self._log = log = read_signals(data, machine)
        sdk = extras.import_extra("foxglove", "foxglove")
        self._websocket = extras.import_extra("foxglove", "foxglove.websocket")
        self._context = sdk.Context()  # kept: the server forgets the topics of one that is no longer referenced
        self._topics = topics_of(self._context, log)
        self.shows_arm = self._topics.shows_arm
        start, end = int(log.stamps[0]), int(log.stamps[-1])
        self._clock = PlaybackClock(start, end, speed)
        self._rate = (len(log.stamps) - 1) / max(end - start, 1) * NS_PER_SECOND  # rows a second, at speed 1
        self._row = self._event = 0  # the next ones
        self._first_viewer: float | None = None
        self._begun = self._scene_due = False
        self._shown_state = ""
        listener = ViewerListener(self._note_subscription, self._control)
        self._server = start_server(self._context, log.name, listener, host=host, port=port, time_range=(start, end))
        self.address = f"ws://{host}:{self._server.port}"
        self.link = str(self._server.app_url())

    def serve(self, stopped: Callable[[], bool] = lambda: False) -> None:
        """Play to viewers that connect, until `stopped()` is true."""
        while not stopped():
            self.step()
            time.sleep(STEP_INTERVAL)

    def step(self) -> None:
        """Send the rows and events whose time has come, and the scene to new viewers; nothing without any viewer."""
        if not self._begun:
            if self._first_viewer is None or time.monotonic() < self._first_viewer + START_DELAY:
                return
            self._begun = True
            self._clock.change(playing=True)
        present, sought = self._clock.read()
        if sought is not None:
            self._seek(sought)
        if self._scene_due:
            self._scene_due = False
            self._topics.log_scene(int(self._log.stamps[0]))
        stride = max(int(np.ceil(self._rate * self._clock.state()[2] / MAX_ROW_RATE)), 1)
        due = int(np.searchsorted(self._log.stamps, present, "right"))
        for index in reversed(range(due - 1, self._row - 1, -stride)):  # with the newest
            stamp = int(self._log.stamps[index])
            self._send_events(stamp)
            self._topics.log_row(stamp, self._log.row(index))
        self._row = max(due, self._row)
        self._send_events(present + 1)
        self._server.broadcast_time(present)
        if (state := self._clock.state()[0]) != self._shown_state:
            self._shown_state = state
            self._server.broadcast_playback_state(self._state())

    def _send_events(self, end: int) -> None:
        """Send the events that are due before a stamp, ns."""
        while self._event < len(self._log.events) and self._log.events[self._event][0] < end:
            self._topics.log_event(*self._log.events[self._event])
            self._event += 1

    def close(self) -> None:
        """End the server."""
        self._server.stop()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _seek(self, stamp: int) -> None:
        """Continue with the last row at or before a stamp, ns, and with the events behind it."""
        self._row = max(int(np.searchsorted(self._log.stamps, stamp, "right")) - 1, 0)
        self._event = sum(event[0] < stamp for event in self._log.events)

    def _note_subscription(self, topic: str) -> None:
        """Begin the playback with the first subscription, and send the scene to whoever subscribes to it."""
        self._first_viewer = self._first_viewer or time.monotonic()
        self._scene_due = self._scene_due or topic == SCENE_TOPIC

    def _control(self, request: Any) -> Any:
        """Obey a viewer's request, and return the state of the playback; a speed that is none changes nothing."""
        speed = float(request.playback_speed)
        self._begun = True
        self._clock.change(
            playing=request.playback_command == self._websocket.PlaybackCommand.Play,
            speed=speed if isfinite(speed) and speed > 0.0 else None,
            stamp=request.seek_time,
        )
        return self._state(did_seek=request.seek_time is not None, request_id=request.request_id)

    def _state(self, *, did_seek: bool = False, request_id: str | None = None) -> Any:
        """Return the state of the playback in the SDK's form."""
        name, stamp, speed = self._clock.state()
        status = getattr(self._websocket.PlaybackStatus, name)
        return self._websocket.PlaybackState(status, stamp, speed, did_seek, request_id)
