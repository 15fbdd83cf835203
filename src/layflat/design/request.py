"""What a joint is asked to do: the request that a joint is sized for, with the range of each value."""

from dataclasses import dataclass
from math import isfinite, pi, radians
from typing import Any, Self

from layflat.description import units as u
from layflat.description.names import file_name
from layflat.errors import DesignError

RANGES: dict[str, tuple[u.Quantity | None, float, float]] = {
    "torque": (u.TORQUE, 0.5, 1500.0),
    "stroke": (u.ANGLE, radians(30.0), radians(200.0)),
    "supply": (u.PRESSURE, 0.5e5, 10e5),
    "wrap": (u.ANGLE, radians(60.0), pi),
    "hose_width": (u.LENGTH, 0.03, 0.4),
    "cylinder_diameter": (u.LENGTH, 0.02, 0.6),
    "strap_width": (u.LENGTH, 0.003, 0.3),
    "strap_thickness": (u.LENGTH, 0.02e-3, 1e-3),
    "link_length": (u.LENGTH, 0.02, 3.0),
    "payload_inertia": (u.INERTIA, 1e-5, 1e3),
    "stress_margin": (None, 1.0, 10.0),
}
"""Kind, least and greatest value (SI) of each request."""

ROUNDING = 1e-9  # share by which a bound may be missed: what is written in another unit is rounded


@dataclass(frozen=True)
class SizingRequest:
    """What a joint must do, in SI; what is None is chosen.

    Raises:
        InputError: the name can't be that of a file.
        DesignError: a value lies outside any sensible range.
    """

    torque: float  # over the whole working stroke at supply pressure, N m
    stroke: float  # working stroke, rad
    supply: float  # gauge supply pressure, Pa
    wrap: float = radians(120.0)  # wrap angle of the collapsed hose, rad
    hose_width: float | None = None  # width of the flat hose, m
    cylinder_diameter: float | None = None  # m
    strap_width: float | None = None  # m
    strap_thickness: float | None = None  # m
    link_length: float | None = None  # from the joint to what it carries, m; the paper's 0.4 m if None
    payload_inertia: float | None = None  # about the joint, kg m2; the paper's 10^-2 kg m2 per N m if None
    stress_margin: float = 1.5  # yield over stress that the strap must keep
    name: str = "sized-joint"  # of the machine and its files

    def __post_init__(self) -> None:
        file_name(self.name, "size: name")
        for key, (kind, least, greatest) in RANGES.items():
            value = getattr(self, key)
            if value is not None and not (
                isfinite(value) and least * (1 - ROUNDING) <= value <= greatest * (1 + ROUNDING)
            ):
                raise DesignError(
                    _text(kind, value),
                    where=f"size: {key}",
                    right=f"give {_text(kind, least)} to {_text(kind, greatest)}",
                )

    @classmethod
    def from_text(cls, **given: str | float | None) -> Self:
        """Return the request of texts with units, such as torque="25 N m"; what is None keeps its default.

        Raises:
            InputError: a text is not a quantity of its kind.
            DesignError: a value lies outside any sensible range.
        """
        values: dict[str, Any] = {}
        for key, value in given.items():
            kind = RANGES[key][0] if key in RANGES else None
            if value is not None:
                values[key] = value if kind is None else u.quantity(value, kind, f"size: {key}")
        for key in ("torque", "stroke", "supply"):
            if key not in values:
                example = getattr(RANGES[key][0], "example", "")
                raise DesignError("is missing", where=f"size: {key}", right=f'give one such as "{example}"')
        return cls(**values)


def _text(kind: u.Quantity | None, value: float) -> str:
    return f"{value:.6g}" if kind is None else str(u.alike(kind.example, value, kind.unit))
