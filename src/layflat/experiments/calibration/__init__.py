"""What the paper leaves open is found from what it reports: `python -m layflat.experiments.calibration`.

A reader's way: unknowns.py (what is open, and within what range), effort.py (how closely to look), steps.py and
evidence.py (the paper's experiments with many machines at once), shortfall.py (how far they are from the paper's
findings), findings.py (the cheapest looks first), search.py (where nothing is short), stages.py (one joint after the
other), __main__.py.
"""
