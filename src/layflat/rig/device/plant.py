"""What the device needs of a machine that moves; whoever can simulate one hands it in."""

from collections.abc import Sequence
from typing import Protocol

from layflat.arrays import Array


class Plant(Protocol):
    """A machine through time, a bit at a time. All arrays are (joints,)."""

    supply: float  # absolute pressure at the valves, Pa; settable
    payload: float  # kg; settable

    @property
    def joints(self) -> Sequence[str]:
        """Names, from base to tip."""

    @property
    def load(self) -> Array:
        """Torque from outside, N m; items can be set."""

    @property
    def time(self) -> float:
        """How far it has been advanced, s."""

    @property
    def angles(self) -> Array:
        """Where the joints are, rad."""

    @property
    def velocities(self) -> Array:
        """How fast they turn, rad/s."""

    @property
    def pressures(self) -> Array:
        """Absolute pressures in hoses A and B, Pa, (joints, 2)."""

    def drive(self, voltages: Array) -> None:
        """Give the valves' drivers voltages, which hold until the next."""

    def advance(self, until: float) -> None:
        """Let time pass up to the last whole step before `until` (s)."""

    def sense(self) -> tuple[Array, Array]:
        """Angles and differential pressures as the converters report them now, noise included."""

    def seize(self, joint: int, opening: float | None) -> None:
        """Hold a joint's spool at an opening (-1 to 1) whatever is asked; None lets it go."""

    def burst(self, joint: int, hose: int | None) -> None:
        """Let a hose of a joint (0: A, 1: B) lose its air through a hole; None mends it."""

    def grip(self, joint: int, torque: float) -> None:
        """Hold a joint as a brake does, by so much more than its own (N m); 0 lets it go."""

    def kink(self, joint: int, share: float) -> None:
        """Narrow what the joint's valve lets through to a share of what it was; 1 mends it."""
