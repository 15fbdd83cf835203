"""What packing cell this is: description files and validated objects."""

from layflat.cell.file.loader import build, load, names, text
from layflat.cell.file.model import Cell

__all__ = ["Cell", "build", "load", "names", "text"]
