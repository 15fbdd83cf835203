#!/usr/bin/env bash
# mcap-ros2-support 0.6.0 and rosbags 0.11.9 read one and the same message of ROS 2 differently, each wrong in one field.
#
# ROS 2 maps both `byte` and `char` of a .msg to unsigned bytes: rosidl_adapter writes `octet` and `uint8` into the IDL
# (https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html, design.ros2.org/articles/legacy_interface_definition.html).
# A field that holds 200 is read as
#
#                     byte   char
#   mcap-ros2-support  200    -56
#   rosbags            -56    200
#
# without a word. Levels, raw counts and states in such fields change their sign by the reader.
# Both say 200 where the definition says `uint8`, which is the same on the wire.
# Run on 2026-11-28, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mcap-ros2-support==0.6.0 rosbags==0.11.9
"$folder/venv/bin/python" - <<'PYTHON'
from mcap_ros2._dynamic import generate_dynamic
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def read(kind):
    definition, data = f"{kind} value\n", b"\0\1\0\0" + bytes([200])  # CDR's head, and one byte
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, "p/msg/One"))
    by_mcap = generate_dynamic("p/msg/One", definition)["p/msg/One"](data).value
    return by_mcap, store.deserialize_cdr(data, "p/msg/One").value


found = {kind: read(kind) for kind in ("byte", "char", "uint8")}
for kind, (mcap, rosbags) in found.items():
    print(f"{kind:6} 200 is read as {mcap} by mcap-ros2-support, as {rosbags} by rosbags")
raise SystemExit(found != {"byte": (200, -56), "char": (-56, 200), "uint8": (200, 200)})
PYTHON
