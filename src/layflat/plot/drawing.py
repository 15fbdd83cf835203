"""Drawing of results by their class."""

from functools import singledispatch
from typing import TYPE_CHECKING, Any

from layflat.description.wrong import shown
from layflat.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@singledispatch
def draw(result: Any) -> "Figure":
    """Draw a result by its own `plot` method, or by the function that is registered for its class.

    Raises:
        InputError: it is nothing that can be drawn.
    """
    if not hasattr(result, "plot"):
        raise InputError(f"{shown(result)} can't be drawn", where="result", right="give a machine, a run, a design ...")
    figure: Figure = result.plot()
    return figure
