"""Lanes: several numbers that a law handles as if they were one.

The four hoses of an arm, or the arms of an ensemble, all obey the same laws. A law that is given lanes instead of
numbers is compiled to vector instructions and works on all of them at once, each lane bit for bit what the scalar law
gives. A law needs nothing for this but `select` where it would write `a if condition else b`, and `&` and `|` where
it would write `and` and `or`.

`join` puts two numbers side by side, or two lanes, or two named tuples of them leaf by leaf; `halves` takes them apart.
`write_row` is the way out of named tuples into arrays; `read_numbers` and `write_numbers` lead from arrays into named
tuples and back, which costs far less than to hand over such tuples from Python. `read_lanes` and `write_lanes` lead
from arrays into lanes and back: an item of a named tuple is a row there, a lane is a column. `slots` are lists without
a heap, `gather` makes a tuple of what they hold, `total` adds the items of one, and `each` calls a law
for every item of tuples.

All of it compiles for CUDA devices too. A thread there has one lane, so that what `read_lanes` gives are plain numbers;
what is joined lies side by side all the same. numba-cuda takes over whatever is registered from outside numba.

What stands here is plain Python (interpreted.py). `compiled` teaches the compiler the same when it is first needed.
"""

from layflat.lanes.interpreted import (
    Lanes,
    each,
    gather,
    halves,
    in_lanes,
    join,
    lane_by_lane,
    leaves,
    mapped,
    read_lanes,
    read_numbers,
    select,
    slots,
    total,
    width,
    write_lanes,
    write_numbers,
    write_row,
)

__all__ = [
    "Lanes",
    "each",
    "gather",
    "halves",
    "in_lanes",
    "join",
    "lane_by_lane",
    "leaves",
    "mapped",
    "read_lanes",
    "read_numbers",
    "select",
    "slots",
    "total",
    "width",
    "write_lanes",
    "write_numbers",
    "write_row",
]
