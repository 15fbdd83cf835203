"""Lift and cup at the arm's tip: what they are told, and what their sensors say."""

from __future__ import annotations

from typing import Protocol

from layflat.cell.scene import Scene


class Tool(Protocol):
    """A lift with a suction cup."""

    @property
    def height(self) -> float:
        """Of the cup's rim over the table, by the lift's stroke, m."""
        ...

    @property
    def speed(self) -> float:
        """Of the lift, upwards, m/s."""
        ...

    @property
    def vacuum(self) -> float:
        """In the cup's line, below the surroundings, Pa."""
        ...

    def obey(self, height: float, *, suction: bool) -> None:
        """Go to a height, m; suck or let go."""


class SceneTool:
    """Lift and cup of a scene."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._top = scene, scene.cell.lift.clearance

    @property
    def height(self) -> float:
        """Of the cup's rim over the table, m."""
        return self._top - self._scene.stroke

    @property
    def speed(self) -> float:
        """Of the lift, upwards, m/s."""
        return -self._scene.stroke_speed

    @property
    def vacuum(self) -> float:
        """Below the surroundings, Pa."""
        return self._scene.cup.vacuum

    def obey(self, height: float, *, suction: bool) -> None:
        """Go to a height, m; suck or let go."""
        self._scene.lift.demand = self._top - height
        self._scene.cup.on = suction
