"""What lies about in trays and on the table and is no produce."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from layflat.cell.file.parts import Colour, Range
from layflat.description import Part
from layflat.description import units as u


class Clutter(Part):
    """One sort of it: thin, seen but hardly felt."""

    shape: Literal["leaf", "sheet", "stick"]
    length: u.Length
    width: u.Length
    colour: Colour
    spread: Annotated[u.Share, Field(le=0.3)] = Field(description="standard deviation of size and brightness, a share")
    count: Range = Field(description="in all trays and on the table together")
