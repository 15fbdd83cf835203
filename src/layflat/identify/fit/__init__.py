"""Fitting a model to its logs."""

from layflat.identify.fit.result import Estimate, Expected, Fit, Quality
from layflat.identify.fit.search import fit
from layflat.identify.fit.selection import fit_selected

__all__ = ["Estimate", "Expected", "Fit", "Quality", "fit", "fit_selected"]
