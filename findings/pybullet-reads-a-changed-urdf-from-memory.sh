#!/usr/bin/env bash
# PyBullet 3.2.7: loadURDF() of a file that has changed gives the robot of the file before, even after
# resetSimulation().
#
# Files are kept by name for as long as a connection lasts (enableFileCaching, on by default). Who writes a URDF, loads
# it, changes a mass and loads it again in a loop, as in identification or a test of an export, gets the first robot
# every time, without a word. setPhysicsEngineParameter(enableFileCaching=0) or a new connection reads anew.
#
# Output seen: "masses: 1 kg, after the change 1.0, after resetSimulation 1.0, without caching 2.0"; 2026-11-28.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check --only-binary :all: pybullet==3.2.7 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys
from pathlib import Path

import pybullet

ROBOT = """<robot name="r"><link name="base"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="l"><inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="l"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def mass():
    return pybullet.getDynamicsInfo(pybullet.loadURDF("robot.urdf", useFixedBase=True), 0)[0]


pybullet.connect(pybullet.DIRECT)
Path("robot.urdf").write_text(ROBOT.format(1))
first = mass()
Path("robot.urdf").write_text(ROBOT.format(2))
changed = mass()
pybullet.resetSimulation()
reset = mass()
pybullet.setPhysicsEngineParameter(enableFileCaching=0)
fresh = mass()
print(f"masses: {first:g} kg, after the change {changed}, after resetSimulation {reset}, without caching {fresh}")
sys.exit(0 if (first, changed, reset, fresh) == (1.0, 1.0, 1.0, 2.0) else 1)
PYTHON
