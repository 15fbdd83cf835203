"""Recorder of a rig's loop: every cycle reaches the disk, whichever process dies.

loop -> ring (shared memory) -> recorder (a process of its own) -> NAME.mcap.part -> NAME.mcap, a run like any other
"""
