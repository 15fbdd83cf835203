#!/usr/bin/env bash
# Open CASCADE 8.0 (through build123d 0.13.0): STEP files of one coloured assembly differ from process to process.
#
# With the time of the header fixed, export_step() of one assembly of six boxes, each of its own colour, should give the
# same bytes in each run. The colours (COLOUR_RGB, with STYLED_ITEM and all between) come in another order in nearly each
# process, by addresses in memory, and so have all entities behind them other numbers. The same assembly without colours
# gives the same file. And within one process the identifiers of occurrences (NEXT_ASSEMBLY_USAGE_OCCURRENCE) count on
# from file to file: the second file of six parts begins with '7'. Whoever compares files of two runs by a checksum
# finds them different without a difference in the assembly; their geometry, names and colours are the same.
# Output: "files of one assembly by 8 processes: 8 in colour, 1 without; occurrences of the second file from 7".
# Run on 2026-11-29, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check build123d==0.13.0
cd "$folder"
cat > export.py <<'PYTHON'
import hashlib
import re
import sys
from datetime import datetime
from pathlib import Path

import build123d as cad

boxes = []
for number in range(6):
    box = cad.Solid.make_box(10 + number, 20, 5).moved(cad.Location((0, 0, 10 * number)))
    box.label = f"box {number}"
    if "coloured" in sys.argv:
        box.color = cad.Color(0.1 + 0.15 * number, 0.5, 0.2)
    boxes.append(box)
assembly = cad.Compound(label="boxes", children=boxes)
texts = []
for name in ("first.step", "second.step"):
    cad.export_step(assembly, name, timestamp=datetime(2000, 1, 1))
    texts.append(Path(name).read_text())
occurrences = re.findall(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('(\d+)'", texts[1])
print(hashlib.sha256(texts[0].encode()).hexdigest(), min(map(int, occurrences)))
PYTHON
run() { for _ in 1 2 3 4 5 6 7 8; do venv/bin/python export.py "$@"; done | sort -u; }
coloured=$(run coloured)
plain=$(run plain)
files=$(echo "$coloured" | wc -l) others=$(echo "$plain" | wc -l) first=$(echo "$plain" | head -1 | cut -d' ' -f2)
echo "files of one assembly by 8 processes: $files in colour, $others without; occurrences of the second file from $first"
[ "$files" -gt 1 ] && [ "$others" -eq 1 ] && [ "$first" -eq 7 ]
