"""The whole packing cell."""

from __future__ import annotations

from typing import Self

from pydantic import Field, PrivateAttr, model_validator

from layflat.cell.file.checks import check
from layflat.cell.file.clutter import Clutter
from layflat.cell.file.parts import Cup, Lift, Limits, Mount, Pack, Table, Tray
from layflat.cell.file.produce import Produce, Spread
from layflat.cell.file.seen import BaseMarkers, Board, Camera, Light, Network, Overview
from layflat.description import Part
from layflat.description.names import Name
from layflat.description.provenance import Provenance
from layflat.machine import Machine


class Cell(Part):
    """A validated description. `provenance` gives the source of each value by its dotted path."""

    name: Name
    title: str
    machine: Machine = Field(description="built-in name or file of the arm")
    mount: Mount
    table: Table
    lift: Lift
    cup: Cup
    camera: Camera
    overview: Overview
    base_markers: BaseMarkers
    board: Board = Field(description="held before the camera to calibrate it")
    ambient: Spread = Field(description="light from everywhere, 1 for a white that fills the picture's range")
    light: dict[str, Light]
    produce: dict[str, Produce]
    tray: dict[str, Tray]
    pack: dict[str, Pack]
    network: Network | None = Field(default=None, description="finds produce; colours do where not given")
    clutter: dict[str, Clutter] = Field(default_factory=dict)
    limits: Limits
    _provenance: dict[str, Provenance] = PrivateAttr(default_factory=dict)
    _origin: str = PrivateAttr(default="")

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        check(self)
        return self

    @property
    def provenance(self) -> dict[str, Provenance]:
        """Source of each value by its dotted path; "given" where the file does not say."""
        return self._provenance

    @property
    def origin(self) -> str:
        """The file or built-in name that it was loaded from: for messages."""
        return self._origin or self.name
