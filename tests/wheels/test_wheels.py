"""Wheels of platforms: what they carry, how they are tagged, and which short runs their machine code comes from."""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from layflat.jit.stored import SOURCES_FOLDER
from layflat.machine import load, names
from wheels import hook
from wheels.hook import PLATFORMS
from wheels.prebuilt import LEVELS, PROCESSORS, machine_commands, shared_commands

PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "layflat"
version = "1"
requires-python = ">=3.11"
[tool.hatch.build.targets.wheel]
packages = ["src/layflat"]
exclude = ["src/layflat/prebuilt"]
[tool.hatch.build.targets.wheel.hooks.custom]
path = "wheels/hook.py"
"""


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    """A function that builds the wheel of a platform of a small project; it returns the wheel's name and its files."""
    builders = pytest.importorskip("hatchling.builders.wheel")
    (tmp_path / "wheels").mkdir()
    (tmp_path / "wheels" / "hook.py").write_bytes(Path(hook.__file__).read_bytes())
    (tmp_path / "pyproject.toml").write_text(PROJECT)
    (tmp_path / "src" / "layflat").mkdir(parents=True)
    (tmp_path / "src" / "layflat" / "__init__.py").write_text("")
    for folder in (*PROCESSORS, SOURCES_FOLDER):
        place = tmp_path / "src" / "layflat" / "prebuilt" / folder
        place.mkdir(parents=True)
        (place / f"of-{folder}").write_text(folder)

    def build_wheel(platform: str) -> list[str]:
        monkeypatch.setenv("LAYFLAT_WHEEL", platform)
        (path,) = builders.WheelBuilder(str(tmp_path)).build(directory=str(tmp_path / "dist" / (platform or "pure")))
        return [Path(path).name, *zipfile.ZipFile(path).namelist()]

    return build_wheel


def test_each_wheel_has_the_code_of_its_platform(build: Callable[[str], list[str]]) -> None:
    x86, arm, pure = (build(platform) for platform in ("x86_64", "aarch64", ""))
    assert x86[0] == "layflat-1-py3-none-manylinux_2_17_x86_64.whl"
    assert arm[0] == "layflat-1-py3-none-manylinux_2_17_aarch64.whl"
    assert pure[0] == "layflat-1-py3-none-any.whl"
    folders = [{name.split("/")[2] for name in wheel if "/prebuilt/" in name} for wheel in (x86, arm, pure)]
    assert folders == [{"linux-x86-64-v2", "linux-x86-64-v3", "linux-x86-64-v4", "sources"},
                       {"linux-aarch64", "sources"}, set()]  # fmt: skip


def test_unknown_platforms_and_missing_code_are_refused(build: Callable[[str], list[str]], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'sparc' is no platform; give x86_64 or aarch64"):
        build("sparc")
    (tmp_path / "src/layflat/prebuilt/linux-aarch64/of-linux-aarch64").unlink()
    with pytest.raises(ValueError, match=r"linux-aarch64 holds nothing: run `python -m wheels.prebuilt` first"):
        build("aarch64")


def test_every_level_is_built_and_belongs_to_a_platform() -> None:
    built = sorted(level for levels in LEVELS.values() for level in levels)
    assert built == sorted(PROCESSORS) == sorted(level for _, levels in PLATFORMS.values() for level in levels)


def test_short_runs_cover_machines_rigs_pages_and_the_readme() -> None:
    for name in names():
        commands: list[Any] = list(machine_commands(name))
        machine = load(name)
        assert len(commands) == (1 if machine.controller is None or machine.valve is None else 4)
    assert any("lf.rollout" in words[1] for words in shared_commands())
