"""What a packing run leaves to look at: a film of the cell, and a sheet with a picture of each pick."""

from layflat.cell.pictures.film import Film, captioned
from layflat.cell.pictures.sheet import ContactSheet

__all__ = ["ContactSheet", "Film", "captioned"]
