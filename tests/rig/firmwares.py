"""The microcontroller's modules, as far as they run here: all but its pins."""

from __future__ import annotations

import importlib
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

FOLDER = Path(__file__).parents[2] / "firmware"


@cache
def firmware(name: str) -> ModuleType:
    """A module of the firmware, whose names are its own only while it is imported."""
    names = ("frames", "settings", "station")
    sys.path.insert(0, str(FOLDER))
    try:
        found = {each: importlib.import_module(each) for each in names}
    finally:
        sys.path.remove(str(FOLDER))
        for each in names:
            sys.modules.pop(each, None)
    return found[name]
