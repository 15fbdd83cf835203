"""Where descriptions of machines and of test benches are found."""

from __future__ import annotations

from pathlib import Path

from layflat.description.library import Library
from layflat.errors import MachineError

_HERE = Path(__file__).parent
_BENCHES = _HERE.parent / "identify" / "benches" / "builtin"
_SHOWN = "`layflat machines` lists them"

MACHINES = Library(_HERE / "builtin", "machine", _SHOWN, 'width = "160 mm"', MachineError)
BENCHES = Library(_BENCHES, "test bench", _SHOWN, 'volume = "10 l"', MachineError)
