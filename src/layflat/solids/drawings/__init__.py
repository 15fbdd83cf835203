"""Drawings of parts that are made, and of the assembly: contours for cutting shops, sheets for workshops."""
