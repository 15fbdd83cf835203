"""Commands load no modules that they do not use, and others that are used later work."""

import subprocess
import sys
from pathlib import Path

LATE = """
import sys
from layflat.cli.trimming import load_late
for name in ("asyncio", "fontTools.agl", "no_package", "no_package.part"):
    load_late(name)
import asyncio, fontTools.agl
assert "asyncio.base_events" not in sys.modules and "no_package" not in sys.modules
print(ord(fontTools.agl.toUnicode("alpha")))
import asyncio.subprocess
print(asyncio.run(asyncio.sleep(0.0, "done")))
load_late("asyncio")
assert sys.modules["asyncio"].run is asyncio.run
"""

SIMULATION = """
import sys
from layflat.cli import main
sys.argv = ["layflat", "simulate", "paper-arm", "--move", "10 deg"]
try:
    main()
except SystemExit as end:
    assert not end.code
loaded = [name for name in ("_ssl", "fontTools.agl", "pyarrow", "dask", "mpl_toolkits.mplot3d") if name in sys.modules]
late = [name for name in loaded if type(sys.modules[name]).__name__ != "LateModule"]
assert not late, late
"""


def run_python(text: str, folder: Path) -> str:
    done = subprocess.run([sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    return done.stdout


def test_late_modules_load_when_they_are_used(tmp_path: Path) -> None:
    assert run_python(LATE, tmp_path).split() == ["945", "done"]


def test_a_simulation_loads_what_it_uses(tmp_path: Path) -> None:
    assert "wrote" in run_python(SIMULATION, tmp_path)
