"""Coarse solids of arms, kept on this computer by machine."""

from __future__ import annotations

import pickle
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from layflat.errors import OutputError
from layflat.files import whole_file
from layflat.jit.cache import DIGITS, cache_folder
from layflat.solids.moving import MovingSolids, moving_solids

if TYPE_CHECKING:
    from layflat.machine import Machine


def kept_solids(machine: Machine, budget: int) -> list[MovingSolids]:
    """Return the solids of an arm within a budget of triangles, as `moving_solids`, whose errors it raises.

    They are kept in the folder of machine code, and made anew once a source of theirs has changed.
    """
    folder = cache_folder(Path(__file__))
    if folder is None:
        return moving_solids(machine, budget)
    file = folder / f"{machine.fingerprint[:DIGITS]}-{budget}.pickle"
    with suppress(OSError, EOFError, pickle.UnpicklingError):
        found: list[MovingSolids] = pickle.loads(file.read_bytes())  # as trusted as the machine code beside it
        return found
    made = moving_solids(machine, budget)
    with suppress(OutputError), whole_file(file, owned=True) as temporary:
        temporary.write_bytes(pickle.dumps(made))
    return made
