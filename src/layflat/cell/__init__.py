"""The packing cell: its description, its physical scene, and what its camera sees."""

from layflat.cell.file import Cell, load, names

__all__ = ["Cell", "load", "names"]
