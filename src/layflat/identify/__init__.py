"""Which parameters explain what was measured."""
