"""Requirements of a joint, and the hoses and cylinders whose swept volume does its work: V = T S/P.

| symbol | meaning | unit |
|---|---|---|
| T, P | torque that is wanted, gauge supply pressure | N m, Pa |
| S | full travel of the output: the working stroke and a reserve | rad |
| V | volume that one hose sweeps | m3 |
| w, D | width of the flat hose, diameter of the cylinder | m |
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import ceil, degrees, isfinite, pi, radians
from typing import Any, Self

from layflat.description import units as u
from layflat.description.names import file_name
from layflat.description.wrong import shown
from layflat.errors import DesignError
from layflat.physics.hose import HoseGeometry

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

# Flat widths, m, in which layflat hose is commonly sold (inch sizes 1 to 8; makers differ by a millimetre or two).
HOSE_WIDTHS = tuple(w * 1e-3 for w in (40, 53, 67, 83, 102, 105, 110, 129, 160, 205, 260, 310))
CHOSEN_RATIO = 0.8, 1.0  # diameter over width when both are chosen here; the paper's joints: 0.95 and 0.93
GIVEN_RATIO = 0.5, 1.8  # the same when one is given: beyond these the hose kinks, or is nearly all dead volume
RESERVE = radians(40.0 / 3.0)  # travel beyond the working stroke: two thirds to the stop, as in the paper's large joint
CONTACT_SHARE = 0.7  # contact angle at full travel over wrap: 84 deg of 120 deg in Table 1


MISSING = object()  # stands for a field without a default


@dataclass(frozen=True)
class SizingRequest:
    """Requirements of a joint, in SI; values that are None are chosen.

    Raise InputError if the name can't be that of a file, DesignError if a value is outside any sensible range.
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
            if value is None and getattr(type(self), key, MISSING) is None:
                continue
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                right = f"give a number in {kind.unit}" if kind is not None else "give a number such as 1.5"
                raise DesignError(f"{shown(value)} is no number", where=f"size: {key}", right=right)
            if not (isfinite(value) and least * (1 - ROUNDING) <= value <= greatest * (1 + ROUNDING)):
                right = f"give {_text(kind, least)} to {_text(kind, greatest)}"
                raise DesignError(_text(kind, value), where=f"size: {key}", right=right)

    @classmethod
    def from_text(cls, **given: str | float | None) -> Self:
        """Return the request of texts with units, such as torque="25 N m"; what is None keeps its default.

        Raise InputError if a text is not a quantity of its kind, DesignError if a value is outside any sensible range.
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


def hoses_and_cylinders(request: SizingRequest, c: float) -> Iterator[tuple[float, float]]:
    """Yield widths of hose, of peel ratio c, and diameters of cylinder that sweep enough, m, the smallest first."""
    needed = request.torque * (request.stroke + RESERVE) / request.supply
    contact_end = CONTACT_SHARE * request.wrap

    def spare(w: float, D: float) -> float:
        return HoseGeometry(w, D / 2, request.wrap, contact_end, c).volume - needed

    chosen = request.hose_width is None and request.cylinder_diameter is None
    least, greatest = CHOSEN_RATIO if chosen else GIVEN_RATIO
    for w in HOSE_WIDTHS if request.hose_width is None else (request.hose_width,):
        D = request.cylinder_diameter
        if D is None:
            D = _smallest(partial(spare, w), least * w, greatest * w)
        elif not least * w <= D <= greatest * w:
            continue
        if D is not None and spare(w, D) >= 0:
            yield w, D


def _smallest(spare: Callable[[float], float], least: float, greatest: float) -> float | None:
    """Return the smallest diameter with volume to spare, in whole millimetres; None where even the largest has none."""
    from scipy.optimize import brentq  # noqa: PLC0415  # SciPy takes long to import

    if spare(greatest) < 0:
        return None
    exact = least if spare(least) >= 0 else float(brentq(spare, least, greatest))
    return ceil(exact * 1e3 - 1e-9) / 1e3


def too_much(request: SizingRequest) -> DesignError:
    """Return the error of a request that no hose and cylinder can do."""
    if request.cylinder_diameter is not None:
        what, better = f"a cylinder of {request.cylinder_diameter * 1e3:.4g} mm", "a larger cylinder"
    elif request.hose_width is not None:
        what, better = f"a hose of {request.hose_width * 1e3:.4g} mm", "a wider hose"
    else:
        what, better = f"the widest hose sold, {HOSE_WIDTHS[-1] * 1e3:.4g} mm,", "more supply pressure"
    wanted = f"{request.torque:.4g} N m over {degrees(request.stroke):.4g} deg at {request.supply / 1e5:.4g} bar"
    right = f"give {better}, or ask for less torque or stroke"
    return DesignError(f"{what} can't give {wanted}", where="size", right=right)
