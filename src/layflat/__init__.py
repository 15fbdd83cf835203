"""Design, simulate and control robot joints made of layflat hose.

The names below are loaded when they are first used, so that importing layflat costs nothing.
"""

from layflat._version import __version__ as __version__
from layflat.lazy import lazy_getattr

_PUBLIC_NAMES = {
    "Batch": "layflat.sim.batch:Batch",
    "DesignError": "layflat.errors:DesignError",
    "DivergedError": "layflat.errors:DivergedError",
    "InputError": "layflat.errors:InputError",
    "LayflatError": "layflat.errors:LayflatError",
    "Machine": "layflat.machine:Machine",
    "MachineError": "layflat.errors:MachineError",
    "MissingExtraError": "layflat.errors:MissingExtraError",
    "OutputError": "layflat.errors:OutputError",
    "Scenario": "layflat.sim:Scenario",
    "SizingRequest": "layflat.design:SizingRequest",
    "changed": "layflat.machine:changed",
    "design_joint": "layflat.design:design_joint",
    "ensemble": "layflat.sim.ensemble:ensemble",
    "export": "layflat.export",
    "foxglove": "layflat.foxglove",
    "gym": "layflat.gym",
    "identify": "layflat.identify",
    "inverse_kinematics": "layflat.motion:inverse_kinematics",
    "linear": "layflat.linear",
    "linearize": "layflat.linear:linearize",
    "load": "layflat.machine:load",
    "metrics": "layflat.sim.run_metrics:metrics",
    "names": "layflat.machine:names",
    "open_run": "layflat.sim:open_run",
    "plan_motion": "layflat.motion:plan_motion",
    "plot": "layflat.plot",
    "read_log": "layflat.identify.logs:read_log",
    "reproduce": "layflat.experiments:reproduce",
    "rollout": "layflat.sim:rollout",
    "save": "layflat.sim:save",
    "size_arm": "layflat.design.arm:size_arm",
    "size_joint": "layflat.design:size_joint",
    "tune": "layflat.tune",
    "units": "layflat.description.units",
    "write_lerobot": "layflat.identify.logs:write_lerobot",
}

__all__ = list(_PUBLIC_NAMES)
__getattr__ = lazy_getattr(__name__, _PUBLIC_NAMES)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
