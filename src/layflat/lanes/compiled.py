"""Teach the compiler lanes: importing this registers their types, instructions, slots, and the way out to Python."""

import layflat.lanes.boxing
import layflat.lanes.lowering
import layflat.lanes.slotting
import layflat.lanes.tuples  # noqa: F401
