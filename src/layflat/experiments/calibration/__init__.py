"""What the paper leaves open is found from what it reports: `python -m layflat.experiments.calibration`.

A reader's way: unknowns.py (what is open, and within what range), evidence.py (the paper's experiments with many
machines at once), shortfall.py (how far they are from the paper's findings), search.py (where none is), __main__.py.
"""
