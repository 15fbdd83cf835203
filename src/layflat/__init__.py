"""Design, simulate and control robot joints made of layflat hose.

The names below are loaded when they are first used, so that importing layflat costs nothing.
"""

from importlib import import_module
from typing import Any

from layflat._version import __version__ as __version__

_HOMES = {
    "Machine": "layflat.machine",
    "Scenario": "layflat.sim",
    "changed": "layflat.machine",
    "design_joint": "layflat.design",
    "ensemble": "layflat.sim.ensemble",
    "load": "layflat.machine",
    "names": "layflat.machine",
    "rollout": "layflat.sim",
    "size_joint": "layflat.design",
}

__all__ = ["Machine", "Scenario", "changed", "design_joint", "ensemble", "load", "names", "rollout", "size_joint"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'layflat' has no attribute {name!r}; it offers {', '.join(__all__)}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
