#!/usr/bin/env bash
# rosbags 0.11.9 leaves out what stands in the write-ahead log of a bag in SQLite, without a word.
#
# rosbag2 records with a write-ahead log in its preset `resilient`, which is meant for recorders that may be cut off
# (https://github.com/ros2/rosbag2#sqlite3-storage-plugin). Where a recorder is killed, the last messages stand in
# NAME.db3-wal until somebody opens the bag with SQLite. rosbags opens it with `immutable=1`, by which SQLite ignores
# that file: of 100 messages it reads 10, and raises nothing. SQLite itself reads 100. What is left out is the end of the
# recording: what happened before the cut.
# Run on 2026-11-28, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rosbags==0.11.9
cd "$folder"
cat > record.py <<'PYTHON'
import os
import sqlite3
import struct

bag = sqlite3.connect("run_0.db3")
bag.execute("PRAGMA journal_mode=WAL")
bag.executescript("""
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
  offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
INSERT INTO schema VALUES(4, 'jazzy');
INSERT INTO topics VALUES(1, '/x', 'std_msgs/msg/Float64', 'cdr', '', '');
INSERT INTO message_definitions VALUES(1, 'std_msgs/msg/Float64', 'ros2msg', 'float64 data', '');
""")
for i in range(100):
    data = b"\0\1\0\0" + struct.pack("<d", i)
    bag.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?, ?)", (i * 10**8, data))
    bag.commit()
    if i == 9:
        bag.execute("PRAGMA wal_checkpoint(TRUNCATE)")
os._exit(1)  # as a recorder that is killed
PYTHON
"$folder/venv/bin/python" record.py || true
"$folder/venv/bin/python" - <<'PYTHON'
import sqlite3
from pathlib import Path

from rosbags.highlevel import AnyReader

with AnyReader([Path("run_0.db3")]) as reader:
    by_rosbags = sum(1 for _ in reader.messages())
(by_sqlite,) = sqlite3.connect("file:run_0.db3?mode=ro", uri=True).execute("SELECT count(*) FROM messages").fetchone()
print(f"rosbags reads {by_rosbags} messages, SQLite {by_sqlite}")
raise SystemExit((by_rosbags, by_sqlite) != (10, 100))
PYTHON
