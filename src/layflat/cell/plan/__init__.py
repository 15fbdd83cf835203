"""Which fruit next, into which place, with which posture and motion, and what to do when a pick fails.

Planning knows the machine's description and what a camera detected, and nothing else.
"""
