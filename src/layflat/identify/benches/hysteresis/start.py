"""How elasto-slip elements begin a log.

An element's state at the start is an initial condition that no log shows: all elements are taken to carry the same
share of what they can, such that the first sample is met as nearly as their limits allow.
"""

from layflat.jit import law


@law
def share_carried(wanted, limit):
    """Share of their limits that elements carry so that `wanted` is met, -1..1."""
    return min(max(wanted / limit, -1.0), 1.0) if limit > 0.0 else 0.0
