"""Firmware: the control cycle of a rig on a microcontroller."""
