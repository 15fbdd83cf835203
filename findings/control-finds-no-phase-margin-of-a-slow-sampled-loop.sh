#!/usr/bin/env bash
# python-control 0.10.2: `margin` of a sampled loop is infinite in phase, though the loop crosses a gain of 1.
#
# For discrete-time systems, polynomials are inaccurate, so `margin` falls back to the response at frequencies of its
# own choice, and a warning says so, as if the result were the better for it. They begin a decade below the slowest pole
# or zero, integrators left out of account. A loop of an integrator that crosses 1 below them, as a slow one around a
# fast actuator does, has no crossover then: its phase margin is inf and its frequency nan, without a further word, at
# any sampling time, while the continuous loop has 83.7 deg. Any limit on the margin is met. With the response at
# frequencies of the user's choice, `margin(frd(loop, w))`, the result is right.
#
# Output seen: "phase margin: continuous 83.7 deg, sampled inf deg, from a response 83.7 deg"; 2026-11-29, Python 3.11.
# Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check control==0.10.2 numpy==2.4.6 scipy==1.17.1
"$folder/venv/bin/python" - 2>"$folder/messages" <<'PYTHON' || { tail -n 20 "$folder/messages" >&2; exit 1; }
import sys

import control
import numpy as np

loop = control.tf([1000.0], [1.0, 110.0, 1000.0, 0.0])  # 1 / (s (1 + s/10) (1 + s/100))
sampled = control.sample_system(loop, 0.001, "zoh")
response = control.frd(sampled, np.geomspace(0.01, 1000.0, 2000))
continuous, discrete, measured = (float(control.margin(system)[1]) for system in (loop, sampled, response))
print(f"phase margin: continuous {continuous:.1f} deg, sampled {discrete:.1f} deg, from a response {measured:.1f} deg")
sys.exit(not (abs(continuous - 83.7) < 0.1 and np.isinf(discrete) and abs(measured - 83.7) < 0.1))
PYTHON
