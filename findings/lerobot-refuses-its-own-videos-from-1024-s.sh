#!/usr/bin/env bash
# lerobot 0.4.4: the loader refuses frames of a data set that its own writer made, once a video is longer than 1024 s.
#
# The writer appends the videos of episodes to one file of up to 200 MB, hours of a small or quiet picture. The loader
# adds the episode's beginning in the file (double precision) to the frame's time in the episode (single precision),
# rounds the sum and the times of the decoded frames to single precision, and requires that they agree within 0.1 ms.
# From 1024 s on, single precision has steps of 0.122 ms: where the two round to neighbours, the frame is there but
# FrameTimestampError is raised, and training ends with the advice to ignore the item. With 30 frames a second this
# begins with episodes of more than 128 s; here, with six of 200 s, in the last one. All settings are the defaults. Data
# sets whose video files end before 1024 s (video_files_size_in_mb, or a file an episode) load in full.
#
# Output seen: "frames refused: 0 of 1000 before 1024 s, 288 of 2160 after 1128 s"; 2026-11-29, Python 3.11. Installs
# some GB (torch). Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check lerobot==0.4.4 av==15.1.0 torch==2.10.0 torchvision==0.25.0 datasets==4.8.5
cd "$folder"
export HF_HUB_OFFLINE=1 HF_HOME="$folder/hf" SVT_LOG=1
"$folder/venv/bin/python" - 2>"$folder/messages" <<'PYTHON' || { tail -n 20 "$folder/messages" >&2; exit 1; }
import sys

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.video_utils import FrameTimestampError

FPS, EPISODES, FRAMES = 30, 6, 6000  # 200 s each
FEATURES = {
    "observation.images.eye": {"dtype": "video", "shape": (32, 32, 3), "names": ["height", "width", "channels"]},
    "observation.state": {"dtype": "float32", "shape": (1,), "names": ["x"]},
    "action": {"dtype": "float32", "shape": (1,), "names": ["x"]},
}

data = LeRobotDataset.create("local/data", fps=FPS, features=FEATURES, root="data")
for _ in range(EPISODES):
    for k in range(FRAMES):
        x = np.array([k], np.float32)
        picture = np.full((32, 32, 3), k % 256, np.uint8)
        data.add_frame({"observation.images.eye": picture, "observation.state": x, "action": x, "task": "wait"})
    data.save_episode()
data.finalize()
data = LeRobotDataset("local/data", root="data", video_backend="pyav")


def count_refused(frames):
    refused = 0
    for k in frames:
        try:
            data[k]
        except FrameTimestampError:
            refused += 1
    return refused


early, late = range(29_000, 30_000), range(1128 * FPS, EPISODES * FRAMES)
before, after = count_refused(early), count_refused(late)
print(f"frames refused: {before} of {len(early)} before 1024 s, {after} of {len(late)} after 1128 s")
sys.exit(0 if before == 0 and after > 0 else 1)
PYTHON
