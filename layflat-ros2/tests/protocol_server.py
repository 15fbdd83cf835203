"""Server of the rosbridge protocol without ROS behind it, and a peer that is connected to it.

The server hands topics, service calls and goals from one client on to the others as version 2 of the protocol documents
it, operations of actions included. It is no rosbridge: it checks no types.
"""

import json
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from threading import Thread
from typing import Any, Self

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.server import ServerConnection, serve

Message = dict[str, Any]
PROVIDED = {"advertise_service": "service", "advertise_action": "action"}
REQUESTS = {"call_service": "service", "send_action_goal": "action"}
REPLIES = {"service_response", "action_feedback", "action_result"}


class ProtocolServer(AbstractContextManager["ProtocolServer"]):
    """The server, at a free port or a given one."""

    def __init__(self, port: int = 0) -> None:
        self.types: dict[str, str] = {}  # of all that was advertised
        self.clients: list[ServerConnection] = []
        self._subscribers: dict[str, list[ServerConnection]] = defaultdict(list)
        self._providers: dict[str, ServerConnection] = {}
        self._requests: dict[str, tuple[ServerConnection, str]] = {}  # client and its own number, by ours
        self._server = serve(self._serve, "127.0.0.1", port)
        self.port = self._server.socket.getsockname()[1]
        self.address = f"ws://127.0.0.1:{self.port}"
        self._thread = Thread(target=self._server.serve_forever)
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        for client in list(self.clients):
            client.close()
        self._thread.join()

    def _serve(self, client: ServerConnection) -> None:
        self.clients.append(client)
        with suppress(ConnectionClosed):
            for text in client:
                self._handle(client, json.loads(text, parse_constant=self._refuse))
        self.clients.remove(client)

    @staticmethod
    def _refuse(constant: str) -> None:
        raise AssertionError(f"JSON has no {constant}")

    def _handle(self, client: ServerConnection, message: Message) -> None:
        operation = message["op"]
        if operation == "advertise":
            self.types[message["topic"]] = message["type"]
        elif operation in PROVIDED:
            name = message[PROVIDED[operation]]
            self.types[name], self._providers[name] = message["type"], client
        elif operation == "subscribe":
            self._subscribers[message["topic"]].append(client)
        elif operation == "publish":
            for other in self._subscribers[message["topic"]]:
                self._send(other, message)
        elif operation in REQUESTS:
            number = f"request-{len(self._requests)}"
            self._requests[number] = client, message["id"]
            self._send(self._providers[message[REQUESTS[operation]]], message | {"id": number})
        elif operation == "cancel_action_goal":
            number = next(ours for ours, theirs in self._requests.items() if theirs == (client, message["id"]))
            self._send(self._providers[message["action"]], message | {"id": number})
        elif operation in REPLIES:
            other, number = self._requests[message["id"]]
            if message.get("result") is False:
                message = {key: value for key, value in message.items() if key != "values"}
            self._send(other, message | {"id": number})
        else:
            raise AssertionError(f"the protocol has no {operation}")

    @staticmethod
    def _send(client: ServerConnection, message: Message) -> None:
        with suppress(ConnectionClosed):
            client.send(json.dumps(message))


class Peer(AbstractContextManager["Peer"]):
    """Client of a server, which keeps all that it receives."""

    def __init__(self, address: str) -> None:
        self._socket = connect(address, max_queue=None, close_timeout=1.0)
        self.received: list[Message] = []
        self._count = 0

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, operation: str, **fields: Any) -> Self:
        self._socket.send(json.dumps({"op": operation, **fields}))
        return self

    def subscribe(self, *topics: str) -> Self:
        for topic in topics:
            self.send("subscribe", topic=topic)
        return self

    def messages(self, topic: str) -> list[Message]:
        return [one["msg"] for one in self.received if one.get("topic") == topic]

    def wait(self, condition: Callable[[], Any], seconds: float = 10.0) -> Any:
        """Receive until a condition holds, and return its value."""
        until = time.monotonic() + seconds
        while not (value := condition()):
            assert time.monotonic() < until, self.received[-3:]
            with suppress(TimeoutError):
                self.received.append(json.loads(self._socket.recv(timeout=0.02)))
        return value

    def call(self, service: str) -> Message:
        """Call a service, and return the values of its response."""
        self._count += 1
        self.send("call_service", service=service, id=f"call-{self._count}", args={})
        reply: Message = self.wait(lambda: self._reply(f"call-{self._count}", "service_response"), 60.0)
        assert reply["result"] is True
        values: Message = reply["values"]
        return values

    def send_goal(self, action: str, args: Message) -> str:
        """Send a goal, and return its number."""
        self._count += 1
        number = f"goal-{self._count}"
        kind = "control_msgs/action/FollowJointTrajectory"
        self.send("send_action_goal", action=action, action_type=kind, id=number, args=args, feedback=True)
        return number

    def result(self, goal: str, seconds: float = 10.0) -> Message:
        """Return the result of a goal, with its status."""
        reply: Message = self.wait(lambda: self._reply(goal, "action_result"), seconds)
        values: Message = reply["values"] | {"status": reply["status"]}
        return values

    def feedback(self, goal: str) -> list[Message]:
        return [one["values"] for one in self.received if one["op"] == "action_feedback" and one["id"] == goal]

    def _reply(self, number: str, operation: str) -> Message | None:
        return next((one for one in self.received if one.get("id") == number and one["op"] == operation), None)
