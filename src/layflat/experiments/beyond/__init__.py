"""What is beyond a controller: how soon a step could be over at best."""

from layflat.experiments.beyond.optimum import Optimum, settling_bound

__all__ = ["Optimum", "settling_bound"]
