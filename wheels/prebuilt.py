"""Build the machine code of kernels that the built-in machines need: `python -m wheels.prebuilt`.

Commands run as people run them, with short runs, and every kernel that they compile is recorded with the types of its
arguments (see `recording/sitecustomize.py`). So no list of kernels can lack one, or hold one that nothing calls.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from layflat.jit.objects import Processor
from layflat.jit.stored import PREBUILT_FOLDER, SOURCES_FOLDER
from layflat.machine import load
from layflat.machine.loader import names
from layflat.registers import MAX_REGISTER_BYTES, MIN_REGISTER_BYTES

ROOT = Path(__file__).parents[1]
LINUX = "unknown-linux-gnu"

PROCESSORS = {
    "linux-x86-64-v2": Processor(f"x86_64-{LINUX}", "x86-64-v2"),
    "linux-x86-64-v3": Processor(f"x86_64-{LINUX}", "x86-64-v3"),
    "linux-x86-64-v4": Processor(f"x86_64-{LINUX}", "x86-64-v4"),
    "linux-aarch64": Processor(f"aarch64-{LINUX}", "generic", "+neon"),
}
"""Processor of each folder of machine code."""

LEVELS = {
    MIN_REGISTER_BYTES: ("linux-x86-64-v2", "linux-x86-64-v3", "linux-aarch64"),
    MAX_REGISTER_BYTES: ("linux-x86-64-v4",),  # kernels of lanes alone; others gain nothing
}
"""Keys of `PROCESSORS` by the size of the vector registers for which their lanes are made, bytes."""

MANY_RUNS = """
from layflat.machine import load
from layflat.pages.studio.cloud import JointStep, simulate_cloud
from layflat.pages.studio.worker import find_figures
machine = load({name!r})
joint = next(iter(machine.joints))
find_figures(0, False, machine, joint)
simulate_cloud(machine, JointStep(joint, 0.02, 0.5), runs=8)
"""
"""Studio on a machine."""

MOVE = ("--move", "1 deg @ 0.1 s", "--duration", "0.3 s")


def machine_commands(name: str) -> Iterator[list[str]]:
    """Yield the command lines of short runs of a built-in machine, as arguments of Python."""
    machine, command = load(name), ["-c", "from layflat.cli import main; main()"]
    yield [*command, "joint", "sweep", name]
    if machine.controller is None or machine.valve is None:
        return
    yield [*command, "simulate", name, *MOVE]
    yield [*command, "rig", "run", name, "--driver", "simulated", "--duration", "0.2 s"]
    yield ["-c", MANY_RUNS.format(name=name)]


def shared_commands() -> Iterator[list[str]]:
    """Yield the command lines of the paper's experiments and of the lines in README.md."""
    yield ["-c", "from layflat.cli import main; main()", "reproduce"]
    lines = re.search(
        r"## Ten lines\n+```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL
    )
    assert lines is not None
    yield ["-c", lines[1]]


def run_recorded(commands: Iterable[list[str]], folder: Path, levels: Iterable[str], register_bytes: int) -> None:
    """Run commands in new processes that record what they compile.

    Args:
        commands: arguments of Python.
        folder: folder of the machine code, a folder each level.
        levels: keys of `PROCESSORS`.
        register_bytes: size of the vector registers that hold lanes.
    """
    targets = {level: PROCESSORS[level] for level in levels}
    with TemporaryDirectory() as place:
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join((str(ROOT / "wheels" / "recording"), str(ROOT / "src"))),
            "LAYFLAT_CACHE_DIR": str(Path(place, "cache")),
            "LAYFLAT_RECORD": str(folder),
            "LAYFLAT_RECORD_TARGETS": json.dumps(targets),
            "LAYFLAT_RECORD_LANES": str(register_bytes),
        }
        for number, words in enumerate(commands):
            described = words[2:] or words[1].strip().splitlines()[-1:]
            print(f"{' '.join(described)} ({', '.join(targets)})", flush=True)
            at = Path(place, str(number))
            at.mkdir()
            done = subprocess.run(
                [sys.executable, *words], check=False, cwd=at, env=environment, capture_output=True, text=True
            )
            # Claims may disagree, and a rig whose laws compile may come too late; both are recorded.
            if done.returncode and "rig" not in words and "wrote" not in done.stdout:
                raise SystemExit(f"{words}: {done.stdout[-500:]} {done.stderr[-2000:]}")


def build(folder: Path, machines: Iterable[str]) -> None:
    """Build all machine code into a new folder.

    Args:
        folder: the folder; parts are added to what is in it.
        machines: names of built-in machines.
    """
    for name in (*PROCESSORS, SOURCES_FOLDER):
        (folder / name).mkdir(parents=True, exist_ok=True)
    for size, levels in LEVELS.items():
        for name in machines:
            run_recorded(machine_commands(name), folder, levels, size)
        run_recorded(shared_commands(), folder, levels, size)


def package_digest() -> str:
    """Return the SHA-256 digest of all sources of the package, and of README.md and these programs."""
    digest = sha256((ROOT / "README.md").read_bytes())
    for folder in (ROOT / "src", ROOT / "wheels"):
        for path in sorted(folder.rglob("*.py")):
            digest.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()


def main() -> None:
    """Build anew what is in the package's folder, unless it is of the present sources."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=PREBUILT_FOLDER, help="default: the package's own folder")
    parser.add_argument("--machine", action="append", help="default: all built-in machines")
    options = parser.parse_args()
    machines = tuple(options.machine or names())
    mark, content = options.out / SOURCES_FOLDER / "package.digest", f"{package_digest()} {' '.join(machines)}"
    if mark.exists() and mark.read_text(encoding="utf-8") == content:
        return
    temporary = options.out.with_name(f"{options.out.name}.{os.getpid()}")
    try:
        build(temporary, machines)
        (temporary / SOURCES_FOLDER / mark.name).write_text(content, encoding="utf-8")
        shutil.rmtree(options.out, ignore_errors=True)
        temporary.rename(options.out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    total = sum(path.stat().st_size for path in options.out.rglob("*.o"))
    print(f"{total / 1e6:.1f} MB in {options.out}")


if __name__ == "__main__":
    main()
