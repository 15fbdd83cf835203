"""Requirements of a joint, and the hoses and cylinders whose swept volume does its work: V = T S/P.

| symbol | meaning | unit |
|---|---|---|
| T, P | required torque, gauge supply pressure | N m, Pa |
| S | full travel of the output: the working stroke and a reserve | rad |
| V | volume that one hose sweeps | m3 |
| w, D | width of the flat hose, diameter of the cylinder | m |
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import partial
from math import ceil, degrees, isfinite, pi, radians
from typing import TYPE_CHECKING

from layflat.description import units as u
from layflat.description.names import file_name
from layflat.description.wrong import shown
from layflat.errors import DesignError
from layflat.physics.hose import HoseGeometry

FIELD_RANGES: dict[str, tuple[u.Quantity | None, float, float]] = {
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
"""Quantity, min and max (SI) of each field of a request."""
BOUND_TOLERANCE = 1e-9  # relative excess of a bound that is accepted, since conversions of units round

# Flat widths, m, in which layflat hose is commonly sold (inch sizes 1 to 8; makers differ by a millimetre or two).
HOSE_WIDTHS = tuple(w * 1e-3 for w in (40, 53, 67, 83, 102, 105, 110, 129, 160, 205, 260, 310))
CHOSEN_RATIO = 0.8, 1.0  # range of diameter over width if both are chosen; the paper's joints: 0.95 and 0.93
GIVEN_RATIO = 0.5, 1.8  # the same if one is given: beyond these the hose kinks, or is nearly all dead volume
TRAVEL_RESERVE = radians(40.0 / 3.0)  # travel beyond the working stroke, as of the paper's large joint
CONTACT_SHARE = 0.7  # contact angle at full travel over wrap: 84 deg of 120 deg in Table 1


@dataclass(frozen=True)
class SizingRequest:
    """Requirements of a joint: numbers in SI units, or texts with units. What is None is chosen by the sizing.

    Raises InputError if the name can't be that of a file or a text is no quantity of its kind, DesignError if a value
    is missing or outside its plausible range.

    Example:
        >>> import layflat as lf
        >>> request = lf.SizingRequest(torque="25 N m", stroke="120 deg", supply="4 bar")
        >>> request.torque, request.supply
        (25.0, 400000.0)
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

    if TYPE_CHECKING:

        def __init__(
            self, torque: str | float, stroke: str | float, supply: str | float, wrap: str | float = "120 deg",
            hose_width: str | float | None = None, cylinder_diameter: str | float | None = None,
            strap_width: str | float | None = None, strap_thickness: str | float | None = None,
            link_length: str | float | None = None, payload_inertia: str | float | None = None,
            stress_margin: float = 1.5, name: str = "sized-joint",
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        file_name(self.name, "size: name")
        for key, (kind, low, high) in FIELD_RANGES.items():
            value: object = getattr(self, key)
            if value is None and key in OPTIONAL_FIELDS:
                continue
            if isinstance(value, str) and kind is not None:
                value = u.quantity(value, kind, f"size: {key}")
                object.__setattr__(self, key, value)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                right = "give a number such as 1.5" if kind is None else f"{kind.right}, or a number in {kind.unit}"
                what = "is missing" if value is None else f"{shown(value)} is no number"
                raise DesignError(what, where=f"size: {key}", right=right)
            if not (isfinite(value) and low * (1 - BOUND_TOLERANCE) <= value <= high * (1 + BOUND_TOLERANCE)):
                right = f"give {_text(kind, low)} to {_text(kind, high)}"
                raise DesignError(f"{_text(kind, value)} is out of range", where=f"size: {key}", right=right)


OPTIONAL_FIELDS = frozenset(one.name for one in fields(SizingRequest) if one.default is None)


def _text(kind: u.Quantity | None, value: float) -> str:
    return f"{value:.6g}" if kind is None else str(u.quantity_text(kind.example, value, kind.unit))


def hoses_and_cylinders(request: SizingRequest, c: float) -> Iterator[tuple[float, float]]:
    """Yield pairs of hose width and the smallest (or requested) cylinder diameter that sweep enough, m, by width.

    Diameter over width stays in `CHOSEN_RATIO`, in `GIVEN_RATIO` if one of them is requested; `c` is the peel ratio.
    """
    needed = request.torque * (request.stroke + TRAVEL_RESERVE) / request.supply
    contact_end = CONTACT_SHARE * request.wrap

    def spare(w: float, D: float) -> float:
        return HoseGeometry(w, D / 2, request.wrap, contact_end, c).volume - needed

    chosen = request.hose_width is None and request.cylinder_diameter is None
    low, high = CHOSEN_RATIO if chosen else GIVEN_RATIO
    for w in HOSE_WIDTHS if request.hose_width is None else (request.hose_width,):
        D = request.cylinder_diameter
        if D is None:
            D = _smallest(partial(spare, w), low * w, high * w)
        elif not low * w <= D <= high * w:
            continue
        if D is not None and spare(w, D) >= 0:
            yield w, D


def _smallest(spare: Callable[[float], float], low: float, high: float) -> float | None:
    """Return the smallest diameter with spare volume, m, rounded up to a millimetre; None if the largest has none."""
    from scipy.optimize import brentq  # noqa: PLC0415  # SciPy takes long to import

    if spare(high) < 0:
        return None
    exact = low if spare(low) >= 0 else float(brentq(spare, low, high))
    return ceil(exact * 1e3 - 1e-9) / 1e3


def explain_infeasible(request: SizingRequest) -> DesignError:
    """Return the error of a request that no hose and cylinder can meet."""
    if request.cylinder_diameter is not None:
        what, better = f"a cylinder of {request.cylinder_diameter * 1e3:.4g} mm", "a larger cylinder"
    elif request.hose_width is not None:
        what, better = f"a hose of {request.hose_width * 1e3:.4g} mm", "a wider hose"
    else:
        what, better = f"the widest hose sold, {HOSE_WIDTHS[-1] * 1e3:.4g} mm,", "more supply pressure"
    requirement = f"{request.torque:.4g} N m over {degrees(request.stroke):.4g} deg at {request.supply / 1e5:.4g} bar"
    right = f"give {better}, or ask for less torque or stroke"
    return DesignError(f"{what} can't give {requirement}", where="size", right=right)
