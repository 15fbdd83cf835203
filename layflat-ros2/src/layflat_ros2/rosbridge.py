"""Client of a rosbridge server: topics, services and actions of ROS 2 as JSON over one WebSocket.

It speaks version 2 of the protocol, operations of actions included. `roslibpy` has no action servers, and a thread of
Twisted of its own.
"""

import json
import threading
from collections.abc import Mapping
from contextlib import AbstractContextManager, suppress
from enum import IntEnum
from queue import Empty, SimpleQueue
from typing import Any

from websockets.exceptions import InvalidURI, WebSocketException
from websockets.sync.client import ClientConnection, connect

from layflat.errors import InputError

Message = dict[str, Any]
RECONNECT_INTERVAL = 1.0  # between two attempts to connect, s
CONNECT_TIMEOUT = 5.0  # for the handshake, s
PING_INTERVAL, PING_TIMEOUT = 1.0, 2.0  # by which a dead link is detected, s
LINK_UP, LINK_DOWN = "link-up", "link-down"  # operations of messages about the link itself


class GoalStatus(IntEnum):
    """End of a goal, as of action_msgs/msg/GoalStatus."""

    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


class Rosbridge(AbstractContextManager["Rosbridge"]):
    """Connection to a rosbridge server, which is made anew where it is lost.

    What is advertised and subscribed is so again after each connection. A message that is sent without one is lost.

    Args:
        address: address of the server, ws://HOST:PORT.

    Raises:
        InputError: it is no address, or nobody answers there.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self._declared: list[Message] = []
        self._received = SimpleQueue[Message]()
        self._over = threading.Event()
        try:
            self._socket: ClientConnection | None = self._connect()
        except InvalidURI:
            right = "give one such as ws://localhost:9090"
            raise InputError(f"{address!r} is no address of a server", where="rosbridge", right=right) from None
        except (OSError, WebSocketException) as error:
            right = "start it: ros2 launch rosbridge_server rosbridge_websocket_launch.xml"
            raise InputError(f"no rosbridge at {address} ({error})", where="rosbridge", right=right) from None
        self._thread = threading.Thread(target=self._keep_receiving, name="layflat-rosbridge", daemon=True)
        self._thread.start()

    @property
    def is_connected(self) -> bool:
        """Return whether there is a connection."""
        return self._socket is not None

    def advertise(self, topic: str, kind: str) -> None:
        """Advertise a topic of a type, to which `publish` sends."""
        self._declare({"op": "advertise", "topic": topic, "type": kind})

    def subscribe(self, topic: str, kind: str) -> None:
        """Subscribe to a topic of a type; only its newest message waits."""
        self._declare({"op": "subscribe", "topic": topic, "type": kind, "queue_length": 1})

    def advertise_service(self, service: str, kind: str) -> None:
        """Advertise a service of a type, whose calls `receive` returns."""
        self._declare({"op": "advertise_service", "service": service, "type": kind})

    def advertise_action(self, action: str, kind: str) -> None:
        """Advertise an action of a type, whose goals and cancellations `receive` returns."""
        self._declare({"op": "advertise_action", "action": action, "type": kind})

    def publish(self, topic: str, message: Mapping[str, Any]) -> None:
        """Publish a message on a topic."""
        self._send({"op": "publish", "topic": topic, "msg": message})

    def respond(self, call: Message, values: Mapping[str, Any]) -> None:
        """Respond to a call of a service."""
        reply = {"op": "service_response", "service": call["service"], "values": values, "result": True}
        self._send(reply | ({"id": call["id"]} if "id" in call else {}))

    def send_feedback(self, action: str, goal: str, values: Mapping[str, Any]) -> None:
        """Send feedback on a goal of an action.

        Args:
            action: name of the action.
            goal: identifier of the goal.
            values: message of the action's feedback type.
        """
        self._send({"op": "action_feedback", "action": action, "id": goal, "values": values})

    def send_result(self, action: str, goal: str, status: GoalStatus, values: Mapping[str, Any]) -> None:
        """Send the result of a goal of an action.

        Servers drop the values where `result` is False, so that the client of a goal that was aborted would not get its
        reason: it is True, and the status says how the goal ended.

        Args:
            action: name of the action.
            goal: identifier of the goal.
            status: how the goal ended.
            values: message of the action's result type.
        """
        fields = {"action": action, "id": goal, "status": status, "values": values}
        self._send({"op": "action_result", "result": True} | fields)

    def receive(self) -> Message | None:
        """Return the next message of the server, or one with the operation LINK_UP or LINK_DOWN; None without any."""
        with suppress(Empty):
            return self._received.get_nowait()
        return None

    def close(self) -> None:
        """End the connection; a second call does nothing."""
        self._over.set()
        if self._socket is not None:
            self._socket.close()
        self._thread.join()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _connect(self) -> ClientConnection:
        return connect(
            self.address,
            open_timeout=CONNECT_TIMEOUT,
            close_timeout=1.0,
            ping_interval=PING_INTERVAL,
            ping_timeout=PING_TIMEOUT,
            max_size=None,
        )

    def _declare(self, message: Message) -> None:
        self._declared.append(message)
        self._send(message)

    def _send(self, message: Message) -> None:
        """Send a message; nothing without a connection."""
        text = json.dumps(message, allow_nan=False)
        if (socket := self._socket) is not None:
            with suppress(OSError, WebSocketException):
                socket.send(text)

    def _keep_receiving(self) -> None:
        """Queue all messages, and connect anew, until the connection is closed."""
        while not self._over.is_set():
            if self._socket is None:
                if not self._over.wait(RECONNECT_INTERVAL):
                    self._reconnect()
                continue
            try:
                self._queue(self._socket.recv())
            except (OSError, WebSocketException):
                self._socket = None
                self._received.put({"op": LINK_DOWN})

    def _reconnect(self) -> None:
        """Connect once more, and declare everything anew; nothing where nobody answers."""
        with suppress(OSError, WebSocketException):
            socket = self._connect()
            for message in self._declared:
                socket.send(json.dumps(message))
            self._socket = socket
            self._received.put({"op": LINK_UP})

    def _queue(self, text: str | bytes) -> None:
        """Queue a message of the server; one that is no JSON object with an operation is ignored."""
        with suppress(ValueError):
            message = json.loads(text)
            if isinstance(message, dict) and isinstance(message.get("op"), str):
                self._received.put(message)
