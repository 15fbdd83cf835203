"""Messages of Foxglove read by others: MCAP by its own reader, protobuf by Google's, live ones over a WebSocket."""

import json
import struct
import time
from base64 import b64decode
from collections import defaultdict
from pathlib import Path
from typing import Any, Self

import pytest

from layflat.arrays import Array

pytest.importorskip("foxglove")
mcap_reader: Any = pytest.importorskip("mcap.reader")
descriptor_pool: Any = pytest.importorskip("google.protobuf.descriptor_pool")
from google.protobuf import descriptor_pb2, message_factory  # noqa: E402

SUBPROTOCOL = "foxglove.sdk.v1"
MESSAGE, TIME, STATE = 1, 2, 5  # first bytes of binary frames of a server
STATUSES = ("playing", "paused", "buffering", "ended")


class Decoder:
    """Decoder of the messages of one schema."""

    def __init__(self, name: str, encoding: str, schema: bytes) -> None:
        self._json = encoding == "jsonschema"
        if self._json:
            self.schema = json.loads(schema)
            return
        assert encoding == "protobuf"
        pool = descriptor_pool.DescriptorPool()
        for file in descriptor_pb2.FileDescriptorSet.FromString(schema).file:
            pool.Add(file)
        self._kind: Any = message_factory.GetMessageClass(pool.FindMessageTypeByName(name))

    def __call__(self, data: bytes) -> Any:
        def refuse(constant: str) -> None:
            raise AssertionError(f"JSON has no {constant}")

        return json.loads(data, parse_constant=refuse) if self._json else self._kind.FromString(data)


def read_messages(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Stamps (ns) and messages of an MCAP file by topic."""
    topics, decoders = defaultdict(list), dict[int, Decoder]()
    with path.open("rb") as file:
        for schema, channel, message in mcap_reader.make_reader(file, validate_crcs=True).iter_messages():
            decode = decoders.setdefault(schema.id, Decoder(schema.name, schema.encoding, schema.data))
            topics[channel.topic].append((message.log_time, decode(message.data)))
    return dict(topics)


def positions(states: list[tuple[int, Any]]) -> list[list[float]]:
    """Angles of /joint_states, rad, by message and joint."""
    return [[joint.position for joint in message.joints] for _, message in states]


def matrix(transform: Any) -> Array:
    """Pose of a transform's child in its parent, (4, 4), by SciPy."""
    import numpy as np
    from scipy.spatial.transform import Rotation

    turn, at = transform.rotation, transform.translation
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    pose[:3, 3] = at.x, at.y, at.z
    return pose


class Viewer:
    """Viewer of a server, which subscribes to all topics, by Foxglove's WebSocket protocol."""

    def __init__(self, address: str) -> None:
        from websockets.sync.client import connect
        from websockets.typing import Subprotocol

        self._socket = connect(address, subprotocols=[Subprotocol(SUBPROTOCOL)], max_size=None, max_queue=None)
        assert self._socket.subprotocol == SUBPROTOCOL
        self.info: dict[str, Any] = {}
        self.topics: dict[str, list[tuple[int, Any]]] = defaultdict(list)
        self.states: list[tuple[str, int, float, str]] = []  # status, stamp (ns), speed, number of the request
        self.time = 0  # of the server, ns
        self._channels: dict[int, tuple[str, Decoder]] = {}

    def receive(self, enough: Any, seconds: float = 20.0) -> Self:
        """Receive until `enough()` is true."""
        until = time.monotonic() + seconds
        while not enough():
            self._take(self._socket.recv(timeout=until - time.monotonic()))
        return self

    def control(self, *, play: bool, speed: float, seek: int | None, number: str) -> None:
        """Request to play or pause, at a speed, from a stamp (ns)."""
        seeking = b"\0" + bytes(8) if seek is None else b"\1" + struct.pack("<Q", seek)
        head = bytes((3, 0 if play else 1)) + struct.pack("<f", speed) + seeking
        self._socket.send(head + struct.pack("<I", len(number)) + number.encode())

    def close(self) -> None:
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _take(self, frame: str | bytes) -> None:
        if isinstance(frame, str):
            message = json.loads(frame)
            if message["op"] == "serverInfo":
                self.info = message
            elif message["op"] == "advertise":
                self._subscribe(message["channels"])
        elif frame[0] == MESSAGE:
            number, stamp = struct.unpack_from("<IQ", frame, 1)
            topic, decode = self._channels[number]
            self.topics[topic].append((stamp, decode(frame[13:])))
        elif frame[0] == TIME:
            (self.time,) = struct.unpack_from("<Q", frame, 1)
        elif frame[0] == STATE:
            status, stamp, speed, _, length = struct.unpack_from("<BQf?I", frame, 1)
            self.states.append((STATUSES[status], stamp, speed, frame[19 : 19 + length].decode()))

    def _subscribe(self, channels: list[dict[str, Any]]) -> None:
        for channel in channels:
            encoding = channel["schemaEncoding"]
            schema = channel["schema"].encode() if encoding == "jsonschema" else b64decode(channel["schema"])
            self._channels[channel["id"]] = channel["topic"], Decoder(channel["schemaName"], encoding, schema)
        wanted = [{"id": channel["id"], "channelId": channel["id"]} for channel in channels]
        self._socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
