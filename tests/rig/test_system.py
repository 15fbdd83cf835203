"""Systems that lack what Linux has: what can run there runs, the rest says so in a line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from layflat.errors import InputError
from layflat.rig.system import require_posix

LOG = Path(__file__).parent / "recorder" / "logs" / "first-version.mcap"

WITHOUT = """
import sys
for name in ("fcntl", "grp", "tty", "termios", "pty", "pwd"):
    sys.modules[name] = None
import os, signal
for name in ("SIGHUP", "pthread_sigmask"):
    delattr(signal, name)
for name in ("sched_getaffinity", "sched_setaffinity", "sched_setscheduler", "fdatasync"):
    delattr(os, name)
os.process_cpu_count = os.cpu_count  # of Python 3.13, which uses one of these
"""


def run(code: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run code where these modules and functions are missing."""
    command = [sys.executable, "-c", WITHOUT + code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_logs_are_read_repaired_and_drivers_found_without_them(tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(LOG.read_bytes()[:-3000])
    code = """
import multiprocessing.connection, subprocess, types
msvcrt = types.ModuleType("msvcrt")
msvcrt.LK_NBLCK, msvcrt.locking = 2, lambda handle, mode, size: None
sys.modules["msvcrt"] = msvcrt
from pathlib import Path
from layflat.machine import load
from layflat.rig.drivers import create_driver
from layflat.rig.recorder.repair import repair
from layflat.rig.recorder.run import read_run
import layflat.rig.process, layflat.rig.recorded, layflat.rig.trials.campaign, layflat.rig.check
print(read_run(Path(sys.argv[1])).sizes["time"])
print(repair(Path(sys.argv[2]))[0].name)
print(type(create_driver("modbus://127.0.0.1:5020", load("paper-arm"))).__name__)
"""
    done = run(code, str(LOG), str(cut))
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["60", "cut.mcap", "ModbusDriver"]


def test_what_takes_posix_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.name", "nt")
    with pytest.raises(InputError, match="rig run: needs Linux or macOS"):
        require_posix("rig run")


@pytest.mark.skipif(not hasattr(os, "SCHED_RESET_ON_FORK"), reason="needs Linux")
def test_what_a_process_with_priority_starts_has_none() -> None:
    code = """
import os, subprocess, sys
from layflat.rig.system import set_fifo_priority
try:
    set_fifo_priority()
except OSError:
    print("refused")
    sys.exit()
show = "import os; print(os.sched_getscheduler(0))"
print(subprocess.run([sys.executable, "-c", show], capture_output=True, text=True).stdout.strip())
"""
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    if told == "refused":
        pytest.skip("real-time priority is not granted here")
    assert told == str(os.SCHED_OTHER)
