"""Trials of the safety functions: failures injected into a virtual rig, their detection, reactions and effects."""
