"""What is found wrong with a machine by its sensors alone: a detector a file, with its limits, its memory and its law.

A detector of a joint is a law `find(limits, memory, ...) -> (memory, fault)`: the number of its fault (see
`rig/safety/faults.py`), or 0. All conditions are written so that what is not a number is at fault. How the limits were
found stands in docs/rig.md.
"""
