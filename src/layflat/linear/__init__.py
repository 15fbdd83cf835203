"""Linear models of plants, for python-control, and the responses that they are compared with.

Example:
    >>> import layflat as lf
    >>> model = lf.linearize("paper-small-joint", joints="held")
    >>> plant = lf.linear.measure_response(model, [1.0])
    >>> pressure, voltage = "small_differential_pressure", "small_voltage"
    >>> s = 1j * plant.omega[0]
    >>> error = abs(model[pressure, voltage](s) / plant[pressure, voltage](s) - 1)
    >>> print(f"{100 * error:.0f} % between model and plant")
    0 % between model and plant
"""

from layflat.linear.loop import loop_margins as loop_margins
from layflat.linear.loop import measure_loops as measure_loops
from layflat.linear.model import linearize as linearize
from layflat.linear.response import measure_response as measure_response
