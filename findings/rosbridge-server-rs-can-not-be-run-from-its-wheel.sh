#!/usr/bin/env bash
# rosbridge-server-rs 0.1.6: installed by pip, its command ends with "Permission denied" instead of serving ROS 2.
#
# The wheel holds the server as a program with mode 755, and a command that executes it. pip gives the right to be
# executed only to entries of the archive that say that they are regular files (mode 100755); these say 755 alone, so
# that the program is written with mode 644. Any wheel that is made in this way loses it, without a message.
# The fix of a user is chmod +x.
#
# Output seen: "in the wheel: 0o755; installed: 0o644; PermissionError"; 2026-11-29, pip 23.2.1 and 25.3.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pip==25.3
"$folder/venv/bin/pip" install -q --disable-pip-version-check rosbridge-server-rs==0.1.6
"$folder/venv/bin/pip" download -q --disable-pip-version-check --no-deps -d "$folder" rosbridge-server-rs==0.1.6
ROS_DISTRO=jazzy "$folder/venv/bin/rosbridge-server-rs" --version 2>"$folder/errors" || true
"$folder/venv/bin/python" - "$folder" <<'PYTHON'
import sys
import zipfile
from pathlib import Path

folder = Path(sys.argv[1])
(wheel,) = folder.glob("*.whl")
name = "rosbridge_server_rs/rosbridge_server_rs_jazzy"
packed = zipfile.ZipFile(wheel).getinfo(name).external_attr >> 16
(program,) = folder.glob(f"venv/lib/*/site-packages/{name}")
installed = program.stat().st_mode & 0o777
error = (folder / "errors").read_text().strip().splitlines()[-1].partition(":")[0]
print(f"in the wheel: {packed:#o}; installed: {installed:#o}; {error}")
sys.exit((packed, installed, error) != (0o755, 0o644, "PermissionError"))
PYTHON
