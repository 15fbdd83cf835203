from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from layflat.rig.driver import DriverError
from layflat.rig.drivers.lock import lock_rig

HOLDER = """
import sys
from layflat.rig.drivers.lock import lock_rig
file = lock_rig("modbus://rig:502")
print("held", flush=True)
sys.stdin.read()
"""


def test_one_holder_at_a_time() -> None:
    first = lock_rig("serial:///dev/rig")
    with pytest.raises(DriverError, match="is driven by process"):
        lock_rig("serial:///dev/rig")
    os.close(lock_rig("serial:///dev/other"))
    os.close(first)
    os.close(lock_rig("serial:///dev/rig"))


def test_a_holder_in_another_process_is_named_and_its_death_frees_the_rig() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(DriverError, match=f"is driven by process {holder.pid} "):
            lock_rig("modbus://rig:502")
        holder.kill()
    os.close(lock_rig("modbus://rig:502"))


def test_where_no_lock_can_be_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LAYFLAT_RUNTIME_DIR", str(tmp_path / "file"))
    with pytest.raises(DriverError, match="LAYFLAT_RUNTIME_DIR"):
        lock_rig("modbus://rig:502")


def test_locks_lie_in_the_users_runtime_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LAYFLAT_RUNTIME_DIR")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    os.close(lock_rig("modbus://rig:502"))
    assert [path.name for path in (tmp_path / "layflat").iterdir()] == ["modbus-rig-502.lock"]
