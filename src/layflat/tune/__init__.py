"""Find a controller's gains. A reader's way: knobs, conditions, search, tuning, validation, page."""

from layflat.tune.tuning import Progress, Tuning, begin

__all__ = ["Progress", "Tuning", "begin"]
