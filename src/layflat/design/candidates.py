"""Hoses and cylinders that sweep what a joint's work takes: V = T S/P.

| symbol | meaning | unit |
|---|---|---|
| T, P | torque that is wanted, gauge supply pressure | N m, Pa |
| S | full travel of the output: the working stroke and a reserve | rad |
| V | volume that one hose sweeps | m3 |
| w, D | width of the flat hose, diameter of the cylinder | m |
"""

from collections.abc import Callable, Iterator
from functools import partial
from math import ceil, degrees, pi, radians

from layflat.design.request import SizingRequest
from layflat.errors import DesignError
from layflat.physics.hose import peeled_volume

HOSE_WIDTHS = tuple(w * 1e-3 for w in (40, 53, 67, 83, 102, 105, 110, 129, 160, 205, 260, 310))
"""Flat widths, m, in which layflat hose is commonly sold (inch sizes 1 to 8; makers differ by a millimetre or two)."""

CHOSEN_RATIO = 0.8, 1.0
"""Cylinder diameter over hose width when both are chosen here. The paper's joints: 0.95 and 0.93."""

GIVEN_RATIO = 0.5, 1.8  # the same when one is given: beyond these the hose kinks, or is nearly all dead volume

RESERVE = radians(40.0 / 3.0)
"""Full travel beyond the working stroke, as in the paper's large joint: two thirds of the way to the stop."""

CONTACT_SHARE = 0.7  # contact angle at full travel over wrap: 84 deg of 120 deg in Table 1


def hoses_and_cylinders(request: SizingRequest, c: float) -> Iterator[tuple[float, float]]:
    """Yield widths of hose and diameters of cylinder that sweep the volume needed, m, the smallest first.

    Args:
        request: what is asked for, and perhaps one or both sizes.
        c: peel ratio of the hose.
    """
    needed = request.torque * (request.stroke + RESERVE) / request.supply
    contact_end = CONTACT_SHARE * request.wrap

    def spare(w: float, D: float) -> float:
        return float(peeled_volume(D / 2, w / pi, request.wrap, contact_end, c)) - needed

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
    return DesignError(
        f"{what} can't give {request.torque:.4g} N m over {degrees(request.stroke):.4g} deg "
        f"at {request.supply / 1e5:.4g} bar",
        where="size",
        right=f"give {better}, or ask for less torque or stroke",
    )
