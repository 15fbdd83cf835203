"""Design of a joint: Eq. (1), exact cams, design rules, sizing and drawings.

Start from `design_joint`, which evaluates a described joint, or `size_joint`, which describes a joint for a request.
Names are loaded when they are first used.
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from layflat.design.cam import Cam, Outline, cam_outline, synthesise
    from layflat.design.characteristic import Characteristic, cylinder_characteristic, wrapped_hose
    from layflat.design.crude_table import Table1, Table1Constants, table1
    from layflat.design.drawing import cam_sheet, layout_sheet, write_drawings
    from layflat.design.joint import design_joint
    from layflat.design.measured import read_characteristic
    from layflat.design.plates import Plate, plate_characteristic
    from layflat.design.request import HOSE_WIDTHS, SizingRequest
    from layflat.design.sizing import Sized, size_joint
    from layflat.design.straplines import Lines, RollerLine, ShellLine
    from layflat.design.strength import StrapStress, strap_stress
    from layflat.design.summary import AirConsumption, Finding, JointDesign, JointMass, refuse_errors

__all__ = [
    "HOSE_WIDTHS", "AirConsumption", "Cam", "Characteristic", "Finding", "JointDesign", "JointMass", "Lines",
    "Outline", "Plate", "RollerLine", "ShellLine", "Sized", "SizingRequest", "StrapStress", "Table1",
    "Table1Constants", "cam_outline", "cam_sheet", "cylinder_characteristic", "design_joint", "layout_sheet",
    "plate_characteristic", "read_characteristic", "refuse_errors", "size_joint", "strap_stress", "synthesise",
    "table1", "wrapped_hose", "write_drawings",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Return a public name from the module that defines it, which is imported at first use.

    Raise AttributeError for any other name.
    """
    for module in iter_modules(__path__) if name in __all__ else ():
        home = import_module(f"{__name__}.{module.name}")
        if name in vars(home) and getattr(vars(home)[name], "__module__", home.__name__) == home.__name__:
            return vars(home)[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
