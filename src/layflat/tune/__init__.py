"""Tuning of controllers: from a machine's description to one with better values of its controller.

`tune_controller` does it all. Read in this order: knobs, conditions, laws, search, robust, tuning, tuned, page. Names
are loaded when they are first used.

Example:
    >>> import layflat as lf
    >>> tuned = lf.tune.tune_controller("paper-small-joint", generations=1, start="current")
    >>> tuned.path.name, tuned.after.cost <= tuned.before.cost
    ('paper-small-joint-tuned.toml', True)
"""

from typing import TYPE_CHECKING

from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.tune.tuned import TunedController, finish_tuning, tune_controller
    from layflat.tune.tuning import REPORT_FILE, Tuning, begin_tuning

__all__ = ["REPORT_FILE", "TunedController", "Tuning", "begin_tuning", "finish_tuning", "tune_controller"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "REPORT_FILE": "layflat.tune.tuning:REPORT_FILE",
        "TunedController": "layflat.tune.tuned:TunedController",
        "Tuning": "layflat.tune.tuning:Tuning",
        "begin_tuning": "layflat.tune.tuning:begin_tuning",
        "finish_tuning": "layflat.tune.tuned:finish_tuning",
        "tune_controller": "layflat.tune.tuned:tune_controller",
    },
)
