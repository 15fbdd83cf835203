"""Tables of text: with any delimiter, decimal sign and encoding, titles, comments, and a row of units."""

from layflat.identify.logs.text.read import read_text

__all__ = ["read_text"]
