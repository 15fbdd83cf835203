"""Ways to reach a far side."""
