"""Fitting a model to its logs."""

from layflat.identify.fit.result import Expected, Fit, FittedParameter, Quality
from layflat.identify.fit.search import fit
from layflat.identify.fit.selection import fit_selected

__all__ = ["Expected", "Fit", "FittedParameter", "Quality", "fit", "fit_selected"]
