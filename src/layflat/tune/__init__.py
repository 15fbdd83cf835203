"""Find a controller's gains. A reader's way: knobs.py, conditions.py, cost.py, search.py, methods.py, tuning.py."""

from layflat.tune.methods import METHODS
from layflat.tune.tuning import Progress, Tuning, begin

__all__ = ["METHODS", "Progress", "Tuning", "begin"]
