"""Identification: from measured signals to a description, with the confidence of each value.

`fit_logs` goes from files to a description, `fit` takes a model of one's own.

Example:
    >>> import layflat as lf
    >>> strong = lf.changed(lf.load("paper-small-joint"), "joint.small.brake.torque", "3 N m")
    >>> run = lf.rollout(strong, [("0.2 s", "20 deg"), ("1.2 s", "-20 deg")], start="0 deg", duration="3 s")
    >>> found = lf.identify.fit_logs(lf.save(run, "log.nc"), "paper-small-joint", blocks="friction", starts=0)
    >>> found.described.joint["small"].brake.torque
    3.0
"""

from typing import TYPE_CHECKING

from layflat.identify.fit import Fit, fit
from layflat.identify.model import Model, ModelOutput, Unknown
from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.identify.fitted_logs import FittedLogs, fit_logs

__all__ = ["Fit", "FittedLogs", "Model", "ModelOutput", "Unknown", "fit", "fit_logs"]

__getattr__ = lazy_getattr(
    __name__,
    {"FittedLogs": "layflat.identify.fitted_logs:FittedLogs", "fit_logs": "layflat.identify.fitted_logs:fit_logs"},
)
