#!/usr/bin/env bash
# gymnasium 1.4.0 takes the mask of a reset out of the caller's options, so that statistics of all episodes are lost.
#
# With autoreset disabled, `reset(options={"reset_mask": mask})` begins the episodes that have ended and leaves the
# others. SyncVectorEnv and AsyncVectorEnv pop the mask from the dictionary of the caller. RecordEpisodeStatistics around
# them looks for it afterwards, finds none, and sets returns and lengths of all episodes to zero, without a word: those
# of the others come out too short. A second reset with the same dictionary resets all environments.
# Run on 2026-11-29, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gymnasium==1.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics

mode = {"autoreset_mode": AutoresetMode.DISABLED}
envs = gymnasium.make_vec("CartPole-v1", 2, vectorization_mode="sync", vector_kwargs=mode)
recorded = RecordEpisodeStatistics(envs)
recorded.reset(seed=1)
for _ in range(5):
    recorded.step(np.array([0, 1]))
before = recorded.episode_lengths.tolist()
options = {"reset_mask": np.array([True, False])}
recorded.reset(options=options)
after = recorded.episode_lengths.tolist()
print(f"steps of the episodes: {before}; after a reset of the first alone: {after}; options left: {options}")
raise SystemExit((before, after, options) != ([5, 5], [0, 0], {}))
PYTHON
