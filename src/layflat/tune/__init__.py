"""Find a controller's gains. A reader's way: knobs.py, conditions.py, cost.py, search.py."""
