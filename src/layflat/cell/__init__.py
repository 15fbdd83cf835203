"""Packing cell: its description, its physical scene, vision, plans of picks, and their execution."""

from layflat.cell.file.loader import load, names
from layflat.cell.file.model import Cell

__all__ = ["Cell", "load", "names"]
