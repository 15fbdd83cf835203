"""Which parameters explain this log: from measured signals to a description, with how sure each value is."""

from layflat.identify.fit import Fit, fit
from layflat.identify.model import Model, Output
from layflat.identify.unknown import Unknown

__all__ = ["Fit", "Model", "Output", "Unknown", "fit"]
