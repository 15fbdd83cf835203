"""Optional packages: which extra brings them, and one error for all that are missing."""

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from layflat.errors import MissingExtraError

EXTRAS: Mapping[str, Mapping[str, str]] = {
    "drawing": {"ezdxf": "ezdxf"},
    "bench": {"mujoco": "mujoco-core"},
    "tune": {"cma": "cma"},
    "study": {"pyarrow": "pyarrow", "pandas": "pandas"},
    "logs": {"mcap": "mcap", "mcap_ros2": "mcap-ros2-support", "rosbags": "rosbags", "pyarrow": "pyarrow"},
    "rig": {"mcap": "mcap", "mcap_ros2": "mcap-ros2-support", "rosbags": "rosbags", "pyarrow": "pyarrow",
            "pymodbus": "pymodbus", "serial": "pyserial", "cobs": "cobs"},
    "gpu": {"numba_cuda": "numba-cuda"},
    "cluster": {"pyarrow": "pyarrow", "pandas": "pandas", "dask": "dask", "distributed": "distributed"},
    "hyddown": {"yaml": "PyYAML"},
    "motion": {"ruckig": "ruckig"},
    "view": {"viser": "viser", "mujoco": "mujoco-core", "trimesh": "trimesh", "collada": "pycollada", "PIL": "pillow"},
    "panel": {"mcap": "mcap", "mcap_ros2": "mcap-ros2-support", "rosbags": "rosbags", "pyarrow": "pyarrow",
              "pymodbus": "pymodbus", "serial": "pyserial", "cobs": "cobs", "nicegui": "nicegui", "trimesh": "trimesh",
              "collada": "pycollada"},
    "cell": {"mujoco": "mujoco-core", "cv2": "opencv-python-headless", "ruckig": "ruckig", "av": "av", "PIL": "pillow"},
}  # fmt: skip
"""Packages of each extra: the name to import, and the name that pip knows."""

REPAIRS: Mapping[str, str] = {
    "mujoco": "pip uninstall -y mujoco mujoco-studio && pip install --force-reinstall --no-deps "
    "'mujoco-core>=4.0.1' glfw PyOpenGL"
}
"""Commands that mend packages of which an upgrade leaves parts behind, by name to import: to install again does not."""


def require(extra: str, *modules: str, where: str = "") -> None:
    """Check, before any work is done, that packages of an extra are installed; import none of them.

    Args:
        extra: a key of `EXTRAS`.
        modules: names to import; default: all of the extra.
        where: what needs them: a command, an option, a file.

    Raises:
        MissingExtraError: naming the packages that are missing, the extra and the command that installs it.
    """
    missing = [module for module in modules or EXTRAS[extra] if not _is_there(module)]
    if missing:
        raise MissingExtraError(extra, [EXTRAS[extra][module] for module in missing], where)


def available(extra: str, *modules: str) -> bool:
    """Return whether packages of an extra are installed: those named, or all of the extra."""
    return all(_is_there(module) for module in modules or EXTRAS[extra])


def module(extra: str, name: str, where: str = "") -> Any:
    """Import a package of an extra, or one of its submodules ("pyarrow.parquet").

    Raises:
        MissingExtraError: it is not installed, or can't be imported.
    """
    package = name.partition(".")[0]
    require(extra, package, where=where)
    try:
        return import_module(name)
    except (ImportError, OSError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0].partition(". ")[0]
        repair = REPAIRS.get(package, "")
        raise MissingExtraError(extra, [EXTRAS[extra][package]], where, reason, repair) from None


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
