"""Checks of the repository's own rules that no tool off the shelf has."""
