"""Programs of exported folders: compiled by the compilers that are there, and run."""

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.export.fmu.libraries import LINKED_SYSTEMS
from layflat.jit.stored import host_levels

STRICT = ["-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
SANITIZED = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
LANGUAGES = {"C": ["-std=c99"], "C++": ["-x", "c++", "-std=c++11"]}
LEVELS = ("linux-x86-64", "linux-x86-64-v3", "linux-x86-64-v4")


def target_runs_here(target: str) -> bool:
    return (target if "-v" in target else f"{target}-v2") in host_levels()


def run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


def build(folder: Path, compiler: str, *options: str, source: str = "example.c", target: str = "linux-x86-64") -> str:
    """Compile a program with the folder's objects; return its path."""
    program = Path(source).with_suffix(f".{Path(compiler).name}-{target}").name
    objects = sorted(map(str, (folder / "lib" / target).iterdir()))
    for name, path in (("program", source), ("parameters", f"{prefix_of(folder)}.c")):
        run([compiler, *options, "-I.", "-c", path, "-o", f"{name}.o"], folder)
    linker = {"gcc": "g++", "clang": "clang++"}.get(compiler, compiler) if "c++" in options else compiler
    linked = [option for option in SANITIZED if option in options]
    run([linker, *linked, "program.o", "parameters.o", *objects, "-lm", "-o", program], folder)
    return f"./{program}"


def prefix_of(folder: Path) -> str:
    """The prefix of all names, that of the only header beside the recording."""
    (header,) = (path for path in folder.glob("*.h") if path.stem != "recorded")
    return header.stem


def needing(tool: str) -> str:
    """The tool, if it is there; else the test is skipped by its name."""
    if shutil.which(tool) is None:
        pytest.skip(f"no {tool}")
    return tool


def zig_compiler(folder: Path, target: str) -> str:
    """Return a C compiler for a system, made by zig; the test is skipped where that is not installed."""
    if find_spec("ziglang") is None:
        pytest.skip("no ziglang")
    (system,) = (one for one in LINKED_SYSTEMS if one.target == target)
    script = folder / f"zig-{target}"
    script.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -m ziglang cc -target {system.triple} "$@"\n', encoding="utf-8"
    )
    script.chmod(0o755)
    return str(script)


def read_trace(text: str) -> Array:
    return np.array([list(map(float, line.split(","))) for line in text.splitlines()[1:]])


def run_board(folder: Path, compiler: str, emulator: str) -> str:
    """Build the example for a board without a warning, run it in an emulator, and return what it prints at its end."""
    needing(compiler), needing(emulator)
    built = subprocess.run(["make"], cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    assert built.stderr == ""
    done = subprocess.run(["make", "-s", "run"], cwd=folder, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, (done.stderr + done.stdout)[-300:]
    return done.stdout.splitlines()[-1]
