"""What is kept of a rig's loop: every cycle, on disk, whatever dies.

loop -> ring (shared memory) -> recorder (a process of its own) -> NAME.mcap.part -> NAME.mcap, a run like any other
"""
