"""The packing cell: its description, its physical scene, and what its camera sees."""

from layflat.cell.file.loader import load, names
from layflat.cell.file.model import Cell

__all__ = ["Cell", "load", "names"]
