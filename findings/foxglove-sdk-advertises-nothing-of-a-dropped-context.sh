#!/usr/bin/env bash
# foxglove-sdk 0.30.3 closes the channels of a context that nobody holds, and writes NaN into JSON messages.
#
# A server and its channels are made with one Context. Where a function makes the context and returns server and
# channels, as a class does that keeps both, Python frees the context at its end. That closes the channels: the server
# goes on to accept viewers, but tells them of no topic. Only a message that is logged prints a warning, once; code that
# asks `has_sinks()` first, as it should where messages are costly, hears nothing.
# And a channel with a JSON schema, whose field is a number, takes NaN: the message holds `NaN`, which is no JSON, so that
# a browser's JSON.parse, and with it the viewer, refuses the whole message, other fields included.
# Run on 2026-11-29, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q foxglove-sdk==0.30.3 websockets==16.1.1 mcap==1.6.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import json

import foxglove
from mcap.reader import make_reader
from websockets.sync.client import connect

SCHEMA = {"type": "object", "title": "Pressure", "properties": {"pressure": {"type": "number"}}}


def make() -> tuple[foxglove.WebSocketServer, foxglove.Channel, foxglove.Context]:
    context = foxglove.Context()
    channel = foxglove.Channel("/pressure", schema=SCHEMA, context=context)
    return foxglove.start_server(port=0, context=context), channel, context


def count_topics(server: foxglove.WebSocketServer) -> int:
    with connect(f"ws://127.0.0.1:{server.port}", subprotocols=["foxglove.sdk.v1"]) as viewer:
        try:
            while True:
                message = json.loads(viewer.recv(timeout=1.0))
                if message["op"] == "advertise":
                    return len(message["channels"])
        except TimeoutError:
            return 0


server, channel, context = make()
kept = count_topics(server)
server.stop()
del server, channel, context
server, channel = make()[:2]
dropped = count_topics(server)
channel.log({"pressure": 1.0})
server.stop()
print(f"topics that a viewer is told of: {kept} with the context held, {dropped} without")

context = foxglove.Context()
channel = foxglove.Channel("/pressure", schema=SCHEMA, context=context)
with foxglove.open_mcap("nan.mcap", context=context):
    channel.log({"pressure": float("nan")})
with open("nan.mcap", "rb") as file:
    (data,) = [message.data for _, _, message in make_reader(file).iter_messages()]
print(f"message of a pressure that is no number: {data.decode()}")
raise SystemExit((kept, dropped, data) != (1, 0, b'{"pressure": NaN}'))
PYTHON
