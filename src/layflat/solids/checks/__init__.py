"""Checks of an assembly: masses, clearances, walls and holes, stresses, and screws that a driver reaches."""
