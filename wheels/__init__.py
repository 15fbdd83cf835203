"""Wheels with prebuilt machine code."""
