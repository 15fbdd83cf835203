"""The machines that the paper allows, in place of one: `python -m layflat.experiments.cloud`.

A reader's way: open.py (what is open, and within what range), __main__.py (machines walk over it, by calibration's
looks and walk), made.py (a cloud's file), spread.py (claims over its members), pinned.py (what they have in common),
held_out.py (what they predict).
"""
