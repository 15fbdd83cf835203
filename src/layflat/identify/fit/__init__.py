"""Fitting a model to its logs."""

from layflat.identify.fit.result import Estimate, Fit, Quality
from layflat.identify.fit.search import fit

__all__ = ["Estimate", "Fit", "Quality", "fit"]
