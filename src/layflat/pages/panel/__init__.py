"""Operator panel: page on which a person runs a rig."""
