"""Fits of logs that others have measured, and the mappings of their columns; the logs themselves are not here."""
