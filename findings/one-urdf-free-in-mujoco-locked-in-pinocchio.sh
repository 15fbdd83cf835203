#!/usr/bin/env bash
# MuJoCo 4.0.1 (mujoco-core) and Pinocchio 4.1.0: a revolute joint whose <limit> has effort and velocity alone, or
# equal limits, turns without any limit in one and can't turn at all in the other.
#
# URDF's lower and upper are optional, and 0 where they are left out. Pinocchio keeps lower = upper = 0: whatever clips,
# samples (randomConfiguration) or optimises within limits leaves the joint at 0. MuJoCo drops a range that is empty
# or the wrong way round, and the joint turns freely; it warns where written limits are equal, not of the other two.
# CAD exporters write such limits by default.
# (layflat takes neither: it asks for --stroke, where the joint is one of the arm's.)
#
# Output seen, for effort only, 0 to 0, 0.3 to 0.3, and 1 to -1: "MuJoCo limited: [False, False, False, False];
# Pinocchio: [(0.0, 0.0), (0.0, 0.0), (0.3, 0.3), (1.0, -1.0)]"; 2026-11-28.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check mujoco-core==4.0.1 pin==4.1.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys

import mujoco
import pinocchio

ROBOT = """<robot name="r"><link name="base"/><link name="l"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="l"/><axis xyz="0 0 1"/>
<limit {} effort="1" velocity="1"/></joint></robot>"""
limited, ranges = [], []
for limits in ("", 'lower="0" upper="0"', 'lower="0.3" upper="0.3"', 'lower="1" upper="-1"'):
    limited.append(bool(mujoco.MjModel.from_xml_string(ROBOT.format(limits)).jnt_limited[0]))
    model = pinocchio.buildModelFromXML(ROBOT.format(limits))
    ranges.append((float(model.lowerPositionLimit[0]), float(model.upperPositionLimit[0])))
print(f"MuJoCo limited: {limited}; Pinocchio: {ranges}")
sys.exit(0 if not any(limited) and ranges == [(0.0, 0.0), (0.0, 0.0), (0.3, 0.3), (1.0, -1.0)] else 1)
PYTHON
