"""A rig that runs, shown to viewers: last cycles from the mailbox of its loop, which does not know of them.

The loop has a process and a processor of its own; a thread of the host reads its snapshots, as an operator's panel
does. The log has all cycles.
"""

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress

from layflat import extras
from layflat.foxglove.server import LOCAL_HOST, ViewerListener, start_server
from layflat.foxglove.signals import NS_PER_SECOND
from layflat.foxglove.topics import SCENE_TOPIC, ArmTopics
from layflat.machine import Machine
from layflat.rig.process import FAULT_LEVELS
from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.recorder.ring import EventLevel
from layflat.rig.session import RigSnapshot

SNAPSHOT_INTERVAL = 0.02  # between two snapshots that are sent, s


class RigServer(AbstractContextManager["RigServer"]):
    """Server that shows a rig: `with RigServer(machine, port=8765) as server: server.follow(session.snapshot)`.

    Args:
        machine: machine of the rig.
        host: address by which viewers reach this computer.
        port: port of the server; 0: any free one.

    Attributes:
        address: address for Foxglove's "Open connection", ws://HOST:PORT.
        link: link that opens the server in Foxglove's web application.

    Raises:
        InputError: host or port can't be had.
        MissingExtraError: Foxglove's SDK is not installed.
    """

    def __init__(self, machine: Machine, *, port: int, host: str = LOCAL_HOST) -> None:
        self._machine = machine
        self._snapshot: Callable[[], RigSnapshot | None] = lambda: None
        self._context = extras.import_extra("foxglove", "foxglove", where="foxglove").Context()
        self._layout = RowLayout.for_machine(machine)
        self._topics = self._topics_of(self._layout)
        self._last: RigSnapshot | None = None
        self._began = 0
        self._scene_due, self._over = True, threading.Event()
        self._server = start_server(
            self._context, machine.name, ViewerListener(self._note_subscription), host=host, port=port
        )
        self.address = f"ws://{host}:{self._server.port}"
        self.link = str(self._server.app_url())
        self._thread = threading.Thread(target=self._keep_sending, name="layflat-foxglove", daemon=True)
        self._thread.start()

    def follow(self, snapshot: Callable[[], RigSnapshot | None]) -> None:
        """Show the cycles that a function returns: None, or a ValueError, where there is none."""
        self._snapshot = snapshot

    def close(self) -> None:
        """End the server; a second call does nothing."""
        if not self._over.is_set():
            self._over.set()
            self._thread.join()
            self._server.stop()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _keep_sending(self) -> None:
        """Send a snapshot every `SNAPSHOT_INTERVAL` until the server is closed."""
        while not self._over.wait(SNAPSHOT_INTERVAL):
            with suppress(ValueError):  # the memory was closed meanwhile
                self._send(self._snapshot())

    def _send(self, shot: RigSnapshot | None) -> None:
        """Send a cycle that was not sent yet, and events where state or fault have changed since the one before."""
        before = self._last
        if shot is None or (before is not None and shot["time"] == before["time"]):
            return
        if shot.layout != self._layout:  # the rig has got another control law
            self._topics.close()
            self._layout, self._topics, before = shot.layout, self._topics_of(shot.layout), None
        if before is None or shot["time"] < before["time"]:  # another loop
            self._began, before = shot.layout.began(shot.row), None
        stamp = self._began + round(float(shot["time"]) * NS_PER_SECOND)
        if self._scene_due:
            self._scene_due = False
            self._topics.log_scene(stamp)
        self._topics.log_row(stamp, {name: shot[name] for name in (*SHARED_COLUMNS, *shot.layout.by_joint)})
        if before is None or shot.state != before.state:
            earlier = f"{before.state.name.lower()} -> " if before is not None else ""
            self._topics.log_event(stamp, EventLevel.INFO, f"{earlier}{shot.state.name.lower()}")
        if shot.fault != (before.fault if before is not None else 0):
            text = shot.fault_text if shot.fault else "no fault any more"
            self._topics.log_event(stamp, FAULT_LEVELS[shot.fault], text)
        self._server.broadcast_time(stamp)
        self._last = shot

    def _topics_of(self, layout: RowLayout) -> ArmTopics:
        """Return the topics of rows with a layout."""
        return ArmTopics(self._context, layout.joints, layout.by_joint, SHARED_COLUMNS, {}, self._machine)

    def _note_subscription(self, topic: str) -> None:
        """Send the scene to whoever subscribes to it."""
        self._scene_due = self._scene_due or topic == SCENE_TOPIC
