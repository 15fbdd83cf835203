"""Optional packages: the extras that install them, and one error for all that are missing."""

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from layflat.errors import MissingExtraError

EXTRA_PACKAGES: Mapping[str, Mapping[str, str]] = {
    "drawing": {"ezdxf": "ezdxf"},
    "bench": {"mujoco": "mujoco-core"},
    "tune": {"cma": "cma"},
    "study": {"pyarrow": "pyarrow", "pandas": "pandas"},
    "logs": {"mcap": "mcap", "mcap_ros2": "mcap-ros2-support", "rosbags": "rosbags", "pyarrow": "pyarrow"},
    "rig": {"mcap": "mcap", "mcap_ros2": "mcap-ros2-support", "rosbags": "rosbags", "pyarrow": "pyarrow",
            "pymodbus": "pymodbus", "serial": "pyserial", "cobs": "cobs"},
    "gpu": {"numba_cuda": "numba-cuda"},
    "cluster": {"pyarrow": "pyarrow", "pandas": "pandas", "dask": "dask", "distributed": "distributed"},
    "foxglove": {"foxglove": "foxglove-sdk"},
    "cad": {"OCP": "cadquery-ocp-novtk", "xlsxwriter": "xlsxwriter", "pygltflib": "pygltflib"},
    "gym": {"gymnasium": "gymnasium"},
    "hyddown": {"yaml": "PyYAML"},
    "motion": {"ruckig": "ruckig"},
    "control": {"control": "control"},
    "export": {"ziglang": "ziglang"},
    "view": {"viser": "viser", "mujoco": "mujoco-core", "trimesh": "trimesh", "collada": "pycollada", "PIL": "pillow"},
    "panel": {"mcap": "mcap", "mcap_ros2": "mcap-ros2-support", "rosbags": "rosbags", "pyarrow": "pyarrow",
              "pymodbus": "pymodbus", "serial": "pyserial", "cobs": "cobs", "nicegui": "nicegui", "trimesh": "trimesh",
              "collada": "pycollada"},
    "cell": {"mujoco": "mujoco-core", "cv2": "opencv-python-headless", "ruckig": "ruckig", "av": "av", "PIL": "pillow"},
}  # fmt: skip
"""Packages of each extra: the name to import, and the name that pip knows."""

REPAIR_COMMANDS: Mapping[str, str] = {
    "mujoco": "pip uninstall -y mujoco mujoco-studio && pip install --force-reinstall --no-deps "
    "'mujoco-core>=4.0.1' glfw PyOpenGL"
}
"""Commands that repair packages of which an upgrade leaves parts behind, by import name."""


def require(extra: str, *modules: str, where: str = "") -> None:
    """Check that packages of an extra are installed, without importing them.

    Args:
        extra: a key of `EXTRA_PACKAGES`.
        modules: import names of the extra's packages, without submodules; default: all of the extra.
        where: the command, option or file that needs them.

    Raises:
        MissingExtraError: naming the packages that are missing, the extra and the command that installs it.
    """
    missing = [module for module in modules or EXTRA_PACKAGES[extra] if not _is_installed(module)]
    if missing:
        raise MissingExtraError(extra, [EXTRA_PACKAGES[extra][module] for module in missing], where)


def available(extra: str, *modules: str) -> bool:
    """Return whether packages of an extra are installed: those named, or all of the extra."""
    return all(_is_installed(module) for module in modules or EXTRA_PACKAGES[extra])


def import_extra(extra: str, name: str, where: str = "") -> Any:
    """Import and return a package of an extra, or one of its submodules.

    Args:
        extra: a key of `EXTRA_PACKAGES`.
        name: import name, such as "pyarrow.parquet".
        where: the command, option or file that needs it.

    Raises:
        MissingExtraError: it is not installed, or can't be imported.
    """
    package = name.partition(".")[0]
    require(extra, package, where=where)
    try:
        return import_module(name)
    except (ImportError, OSError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0].partition(". ")[0]
        repair = REPAIR_COMMANDS.get(package, "")
        raise MissingExtraError(extra, [EXTRA_PACKAGES[extra][package]], where, reason, repair) from None


def _is_installed(module: str) -> bool:
    """Return whether a module is installed, without importing it."""
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
